// Strict reading of a node's private parameters. The parameter server turns what YAML does not take for a
// number into a string (`1e3`) and roscpp's own readers then fall back to a default silently; here a number
// may come as a string that is a number throughout (1e3 is 1000), anything else of the wrong type or range,
// and every parameter that nobody read, is an error that names it.
#pragma once

#include <XmlRpcValue.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/yaml.h"

namespace ros {
class NodeHandle;
}

namespace wheel_twin::nodes {

class Params {
 public:
  /// `values`: the struct of the private namespace, or an invalid value where nothing is set. `name` is the
  /// namespace, for messages.
  Params(const XmlRpc::XmlRpcValue& values, std::string name);

  /// All throw Error naming the parameter when it is there and wrong.
  double number(const std::string& key, double fallback, yaml::Range range = {});
  std::optional<double> optional_number(const std::string& key, yaml::Range range = {});
  int integer(const std::string& key, int fallback, int minimum, int maximum);
  bool boolean(const std::string& key, bool fallback);
  std::string text(const std::string& key, const std::string& fallback);
  std::string choice(const std::string& key, const std::string& fallback,
                     const std::set<std::string>& allowed);
  std::vector<std::string> words(const std::string& key);  ///< a text's parts between blanks
  /// Empty when it is not set. Under roslaunch a node has no working directory of its own: a relative path is
  /// refused.
  std::string absolute_path(const std::string& key);

  void finish() const;  ///< refuses parameters that nobody read

 private:
  XmlRpc::XmlRpcValue* find(const std::string& key);
  [[noreturn]] void fail(const std::string& key, const std::string& message) const;

  XmlRpc::XmlRpcValue values_;
  std::string name_;
  std::set<std::string> read_;
};

/// All parameters of the node's private namespace, as the server has them now.
Params params_of(const ros::NodeHandle& private_node);

}  // namespace wheel_twin::nodes
