#include "logs/bag_record.h"

#include <algorithm>
#include <array>
#include <vector>

namespace wheel_twin::logs {
namespace {

// Record headers hold a few numbers and, for a connection, a topic name: 64 KiB is beyond any of them.
constexpr std::uint32_t header_limit = 64 * 1024;
constexpr std::uint32_t shortest_header = 4 + 4;  // one field "op=" and its byte

std::uint32_t little_u32(const std::uint8_t* bytes) {
  return static_cast<std::uint32_t>(bytes[0]) | static_cast<std::uint32_t>(bytes[1]) << 8 |
         static_cast<std::uint32_t>(bytes[2]) << 16 | static_cast<std::uint32_t>(bytes[3]) << 24;
}

bool has_required_fields(Op op, const Fields& fields) {
  switch (op) {
    case Op::message:
      return field_u32(fields, "conn") && field_u64(fields, "time");
    case Op::bag_header:
      return field_u64(fields, "index_pos").has_value();
    case Op::index:
      return field_u32(fields, "conn").has_value();
    case Op::chunk:
      return fields.count("compression") == 1 && field_u32(fields, "size");
    case Op::chunk_info:
      return field_u64(fields, "chunk_pos").has_value();
    case Op::connection:
      return field_u32(fields, "conn") && fields.count("topic") == 1;
  }
  return false;
}

}  // namespace

std::optional<std::uint32_t> field_u32(const Fields& fields, const std::string& name) {
  const auto field = fields.find(name);
  if (field == fields.end() || field->second.size() != 4) return std::nullopt;
  return little_u32(reinterpret_cast<const std::uint8_t*>(field->second.data()));
}

std::optional<std::uint64_t> field_u64(const Fields& fields, const std::string& name) {
  const auto field = fields.find(name);
  if (field == fields.end() || field->second.size() != 8) return std::nullopt;
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(field->second.data());
  return static_cast<std::uint64_t>(little_u32(bytes)) | static_cast<std::uint64_t>(little_u32(bytes + 4))
                                                             << 32;
}

std::string field_text(const Fields& fields, const std::string& name) {
  const auto field = fields.find(name);
  return field == fields.end() ? std::string() : field->second;
}

std::optional<Fields> parse_fields(const std::uint8_t* data, std::size_t size) {
  Fields fields;
  std::size_t at = 0;
  while (at < size) {
    if (size - at < 4) return std::nullopt;
    const std::uint32_t length = little_u32(data + at);
    at += 4;
    if (length > size - at) return std::nullopt;
    const auto* begin = reinterpret_cast<const char*>(data + at);
    const char* const end = begin + length;
    const char* const equals = std::find(begin, end, '=');
    if (equals == end || equals == begin) return std::nullopt;
    fields[std::string(begin, equals)] = std::string(equals + 1, end);
    at += length;
  }
  return fields;
}

std::optional<Record> read_record(ByteSource& source, std::uint64_t offset) {
  std::array<std::uint8_t, 8> lengths{};
  if (!source.read(offset, lengths.size(), lengths.data())) return std::nullopt;
  const std::uint32_t header_size = little_u32(lengths.data());
  if (header_size < shortest_header || header_size > header_limit ||
      little_u32(lengths.data() + 4) > header_size - 4)
    return std::nullopt;
  std::array<std::uint8_t, 256> small{};
  std::vector<std::uint8_t> large;
  std::uint8_t* header = small.data();
  if (header_size + 4 > small.size()) {
    large.resize(header_size + 4);
    header = large.data();
  }
  if (!source.read(offset + 4, header_size + 4, header)) return std::nullopt;
  auto fields = parse_fields(header, header_size);
  if (!fields) return std::nullopt;
  const std::string op = field_text(*fields, "op");
  if (op.size() != 1 || op[0] < 2 || op[0] > 7) return std::nullopt;
  Record record;
  record.op = static_cast<Op>(op[0]);
  if (!has_required_fields(record.op, *fields)) return std::nullopt;
  record.fields = std::move(*fields);
  record.begin = offset;
  record.data_begin = offset + 4 + header_size + 4;
  record.data_size = little_u32(header + header_size);
  return record;
}

std::uint64_t find_record(ByteSource& source, std::uint64_t offset) {
  constexpr std::size_t block = 1UL << 15;
  constexpr std::size_t overlap = 8;
  std::vector<std::uint8_t> bytes(block + overlap);
  const std::uint64_t size = source.size();
  while (offset + overlap < size) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), size - offset));
    if (!source.read(offset, count, bytes.data())) return size;
    for (std::size_t i = 0; i + overlap <= count; ++i) {
      // The two high bytes of the header's and of its first field's length are 0 in every record.
      if (bytes[i + 2] != 0 || bytes[i + 3] != 0 || bytes[i + 6] != 0 || bytes[i + 7] != 0) continue;
      if (read_record(source, offset + i)) return offset + i;
    }
    offset += count - overlap + 1;
  }
  return size;
}

}  // namespace wheel_twin::logs
