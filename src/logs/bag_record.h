// One record of a bag of format 2.0: a header of fields `name=value`, then data. Lengths are checked against
// what is there.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "logs/byte_source.h"

namespace wheel_twin::logs {

enum class Op : std::uint8_t {
  message = 2,
  bag_header = 3,
  index = 4,
  chunk = 5,
  chunk_info = 6,
  connection = 7
};

using Fields = std::map<std::string, std::string>;

struct Record {
  Op op = Op::message;
  Fields fields;
  std::uint64_t begin = 0;  ///< of the record
  std::uint64_t data_begin = 0;
  std::uint64_t data_size = 0;  ///< as claimed: may pass the end of the source
  std::uint64_t data_end() const { return data_begin + data_size; }
};

/// Little-endian unsigned number of a field; none when the field is missing or has another width.
std::optional<std::uint32_t> field_u32(const Fields& fields, const std::string& name);
std::optional<std::uint64_t> field_u64(const Fields& fields, const std::string& name);
std::string field_text(const Fields& fields, const std::string& name);  ///< empty when missing

/// Splits `size` bytes into fields; none when they are not wholly fields.
std::optional<Fields> parse_fields(const std::uint8_t* data, std::size_t size);

/// The record at `offset`; none when there is no complete, plausible record header with the fields that its
/// op needs.
std::optional<Record> read_record(ByteSource& source, std::uint64_t offset);

/// Offset of the first plausible record at or after `offset`, or the size of the source.
std::uint64_t find_record(ByteSource& source, std::uint64_t offset);

}  // namespace wheel_twin::logs
