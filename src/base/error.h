// The one exception of this project: a message of one line that names the file, key, topic or step at fault.
#pragma once

#include <stdexcept>
#include <string>

namespace wheel_twin {

class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace wheel_twin
