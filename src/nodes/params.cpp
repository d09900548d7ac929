#include "nodes/params.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ros/node_handle.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <utility>

#include "base/error.h"

namespace wheel_twin::nodes {
namespace {

using XmlRpc::XmlRpcValue;

/// A string that is a decimal number from end to end. `010` and `0x10` are refused: they mean different
/// things to different readers.
std::optional<double> whole_number(const std::string& text) {
  const std::size_t digits = text.find_first_not_of("+-");
  if (digits == std::string::npos || digits > 1) return std::nullopt;
  if (text[digits] == '0' && digits + 1 < text.size() &&
      std::isalnum(static_cast<unsigned char>(text[digits + 1])) && text[digits + 1] != 'e' &&
      text[digits + 1] != 'E')
    return std::nullopt;
  if (text.find_first_not_of("+-.0123456789eE") != std::string::npos) return std::nullopt;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end != text.c_str() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

Params::Params(const XmlRpcValue& values, std::string name) : values_(values), name_(std::move(name)) {}

void Params::fail(const std::string& key, const std::string& message) const {
  throw Error(fmt::format("parameter {}/{}: {}", name_, key, message));
}

XmlRpcValue* Params::find(const std::string& key) {
  read_.insert(key);
  if (values_.getType() != XmlRpcValue::TypeStruct || !values_.hasMember(key)) return nullptr;
  return &values_[key];
}

std::optional<double> Params::optional_number(const std::string& key, yaml::Range range) {
  XmlRpcValue* value = find(key);
  if (value == nullptr) return std::nullopt;
  double number = 0.0;
  if (value->getType() == XmlRpcValue::TypeDouble) {
    number = static_cast<double>(*value);
  } else if (value->getType() == XmlRpcValue::TypeInt) {
    number = static_cast<int>(*value);
  } else if (value->getType() == XmlRpcValue::TypeString) {
    const auto parsed = whole_number(static_cast<std::string>(*value));
    if (!parsed) fail(key, fmt::format("'{}' is not a number", static_cast<std::string>(*value)));
    number = *parsed;
  } else {
    fail(key, "must be a number");
  }
  if (!(number >= range.minimum && number <= range.maximum) || !std::isfinite(number))
    fail(key, fmt::format("{} is outside {} to {}", number, range.minimum, range.maximum));
  return number;
}

double Params::number(const std::string& key, double fallback, yaml::Range range) {
  return optional_number(key, range).value_or(fallback);
}

int Params::integer(const std::string& key, int fallback, int minimum, int maximum) {
  const auto number = optional_number(key, {static_cast<double>(minimum), static_cast<double>(maximum)});
  if (!number) return fallback;
  if (*number != std::floor(*number)) fail(key, fmt::format("{} is not a whole number", *number));
  return static_cast<int>(*number);
}

bool Params::boolean(const std::string& key, bool fallback) {
  XmlRpcValue* value = find(key);
  if (value == nullptr) return fallback;
  if (value->getType() != XmlRpcValue::TypeBoolean) fail(key, "must be true or false");
  return static_cast<bool>(*value);
}

std::string Params::text(const std::string& key, const std::string& fallback) {
  XmlRpcValue* value = find(key);
  if (value == nullptr) return fallback;
  if (value->getType() != XmlRpcValue::TypeString) fail(key, "must be a text");
  return static_cast<std::string>(*value);
}

std::string Params::choice(const std::string& key, const std::string& fallback,
                           const std::set<std::string>& allowed) {
  std::string chosen = text(key, fallback);
  if (allowed.count(chosen) == 0)
    fail(key, fmt::format("'{}' is none of {}", chosen, fmt::join(allowed, ", ")));
  return chosen;
}

std::vector<std::string> Params::words(const std::string& key) {
  std::istringstream parts(text(key, ""));
  return {std::istream_iterator<std::string>(parts), {}};
}

std::string Params::absolute_path(const std::string& key) {
  std::string path = text(key, "");
  if (!path.empty() && std::filesystem::path(path).is_relative())
    fail(key, fmt::format("'{}' must be an absolute path: a node has no working directory of its own under "
                          "roslaunch",
                          path));
  return path;
}

void Params::finish() const {
  if (values_.getType() != XmlRpcValue::TypeStruct) return;
  XmlRpcValue values = values_;
  for (const auto& entry : values)
    if (read_.count(entry.first) == 0) fail(entry.first, "is not known");
}

Params params_of(const ros::NodeHandle& private_node) {
  XmlRpcValue values;
  private_node.getParam(private_node.getNamespace(), values);
  return {values, private_node.getNamespace()};
}

}  // namespace wheel_twin::nodes
