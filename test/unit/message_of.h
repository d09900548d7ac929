// What an action says when it refuses: the text of its wheel_twin::Error, "no error" when it does not throw.
#pragma once

#include <string>

#include "base/error.h"

namespace wheel_twin {

template <typename Action>
std::string message_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace wheel_twin
