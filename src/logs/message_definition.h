// Reads chosen fields of a message of any type by the definition that travels in its bag, so that messages of
// foreign packages, and of other versions of them, are read without their headers. ROS 1 serialisation:
// little endian, fields in the order of the definition, 32-bit lengths before strings and arrays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace wheel_twin::logs {

class MessageDefinition {
 public:
  /// `definition`: the full text of a bag's connection header, nested types included. `fields`: dotted paths
  /// of numbers, such as `wrench.wrench.force.x`; a time has the parts `secs` and `nsecs`. Throws Error
  /// naming `type` and the field when a path is not a number of this message, or the line of a definition
  /// that makes no sense.
  MessageDefinition(const std::string& type, const std::string& definition,
                    const std::vector<std::string>& fields);
  ~MessageDefinition();
  MessageDefinition(MessageDefinition&&) noexcept;
  MessageDefinition& operator=(MessageDefinition&&) noexcept;

  /// The fields of one message, in the order asked for. Throws Error when the message is shorter or longer
  /// than its definition says.
  std::vector<double> read(const std::uint8_t* data, std::size_t size) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheel_twin::logs
