#include "logs/bag_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "base/error.h"
#include "logs/bag_record.h"
#include "logs/chunk.h"

namespace wheel_twin::logs {
namespace {

constexpr char version_line[] = "#ROSBAG V2.0\n";
constexpr std::size_t version_size = sizeof(version_line) - 1;
constexpr std::size_t damage_kept = 20;
constexpr std::uint64_t message_limit = 64ULL << 20;    // a large point cloud has a few MiB
constexpr std::uint64_t definition_limit = 4ULL << 20;  // of a connection's data: definitions have a few KiB
constexpr std::size_t connection_limit = 65536;

void require_version(ByteSource& source, const std::string& name) {
  if (source.size() == 0) throw Error(fmt::format("{}: is empty (0 bytes)", name));
  std::string line(static_cast<std::size_t>(std::min<std::uint64_t>(version_size, source.size())), '\0');
  source.read(0, line.size(), line.data());
  if (line == version_line) return;
  if (line.rfind("#ROSBAG V", 0) == 0) {
    const std::string version =
        line.substr(9, line.find('\n') == std::string::npos ? line.npos : line.find('\n') - 9);
    throw Error(
        fmt::format("{}: is a bag of format {}, only 2.0 can be read (rosbag fix converts)", name, version));
  }
  std::string shown;
  for (const char c : line) shown += std::isprint(static_cast<unsigned char>(c)) != 0 ? c : '.';
  throw Error(fmt::format("{}: is no bag: it begins with '{}' instead of '#ROSBAG V2.0'", name, shown));
}

class Scanner {
 public:
  Scanner(ByteSource& source, const BagVisitor& visit) : source_(source), visit_(visit) {
    summary_.file_size = source.size();
  }

  ScanSummary scan(const std::string& name) {
    require_version(source_, name);
    read_index(name);
    walk(source_, version_size, true);
    std::uint64_t first_orphan = 0;
    for (const auto& orphan : orphans_) {
      summary_.orphans += orphan.second;
      first_orphan = orphan.first;
    }
    if (summary_.orphans > 0)
      damage(0, fmt::format("{} messages of a connection ({}) that is described nowhere", summary_.orphans,
                            first_orphan));
    return std::move(summary_);
  }

 private:
  void damage(std::uint64_t offset, std::string text) {
    ++summary_.damage_count;
    if (summary_.damage.size() < damage_kept) summary_.damage.push_back({offset, std::move(text)});
  }

  /// Connections are described once, in the chunk of their first message, and again in the index: read them
  /// there first, so that the loss of a chunk does not cost the messages of the others.
  void read_index(const std::string& name) {
    const auto header = read_record(source_, version_size);
    std::uint64_t position = 0;
    if (header && header->op == Op::bag_header) {
      const std::string encryptor = field_text(header->fields, "encryptor");
      if (!encryptor.empty())
        throw Error(fmt::format("{}: is encrypted ({}): it cannot be read", name, encryptor));
      position = field_u64(header->fields, "index_pos").value_or(0);
    }
    const auto first = position >= version_size ? read_record(source_, position) : std::nullopt;
    summary_.indexed = first && (first->op == Op::connection || first->op == Op::chunk_info);
    // Without the place of the index the records are followed from the start, chunks passed over whole.
    std::uint64_t offset = summary_.indexed ? position : version_size;
    while (offset < source_.size()) {
      const auto record = read_record(source_, offset);
      if (!record) break;
      if (record->op == Op::connection) read_connection(source_, *record);
      offset = record->data_end();
    }
  }

  void read_connection(ByteSource& source, const Record& record) {
    const std::uint32_t id = field_u32(record.fields, "conn").value_or(0);
    if (summary_.connections.count(id) == 1) return;
    if (summary_.connections.size() >= connection_limit || record.data_size > definition_limit) return;
    std::vector<std::uint8_t> data(static_cast<std::size_t>(record.data_size));
    if (!source.read(record.data_begin, data.size(), data.data())) return;
    const auto fields = parse_fields(data.data(), data.size());
    if (!fields || fields->count("type") == 0 || fields->count("md5sum") == 0) return;
    BagConnection& connection = summary_.connections[id];
    connection.id = id;
    connection.topic = field_text(record.fields, "topic");
    connection.type = field_text(*fields, "type");
    connection.md5sum = field_text(*fields, "md5sum");
    connection.definition = field_text(*fields, "message_definition");
    connection.header = *fields;
  }

  /// Follows the records from `offset`. `is_file`: chunks may occur; else these are the bytes of one (at
  /// `file_offset_`).
  void walk(ByteSource& source, std::uint64_t offset, bool is_file) {
    const std::uint64_t end = source.size();
    while (offset < end) {
      const auto record = read_record(source, offset);
      if (!record) {
        offset = resume(source, offset, offset + 1, is_file, "no readable record");
        continue;
      }
      if (record->op == Op::chunk && is_file) {
        offset = read_chunk(*record);
        continue;
      }
      if (record->data_end() > end) {
        offset = resume(source, offset, record->data_begin, is_file,
                        fmt::format("a record of {} bytes does not fit", record->data_size));
        continue;
      }
      // A wrong length shows in what follows. If a record begins inside this one, the length was wrong; else
      // it is whole and the damage lies behind it.
      if (!follows(source, record->data_end()) &&
          find_record(source, record->data_begin) < record->data_end()) {
        offset = resume(source, offset, record->data_begin, is_file,
                        fmt::format("a record whose length of {} bytes is wrong", record->data_size));
        continue;
      }
      if (record->op == Op::message) read_message(source, *record, is_file);
      if (record->op == Op::connection) read_connection(source, *record);
      offset = record->data_end();
    }
  }

  static bool follows(ByteSource& source, std::uint64_t offset) {
    return offset == source.size() || read_record(source, offset).has_value();
  }

  /// Notes damage at `offset` and finds where to go on.
  std::uint64_t resume(ByteSource& source, std::uint64_t offset, std::uint64_t search, bool is_file,
                       const std::string& text) {
    const std::uint64_t next = find_record(source, search);
    summary_.skipped_bytes += next - offset;
    damage(is_file ? offset : chunk_offset_,
           next == source.size() ? fmt::format("{}, nothing after it", text)
                                 : fmt::format("{}, passed over {} bytes", text, next - offset));
    return next;
  }

  void read_message(ByteSource& source, const Record& record, bool is_file) {
    const std::uint32_t id = field_u32(record.fields, "conn").value_or(0);
    if (record.data_size > message_limit) {
      damage(is_file ? record.begin : chunk_offset_,
             fmt::format("a message of {} MiB is not read", record.data_size >> 20));
      return;
    }
    const auto connection = summary_.connections.find(id);
    if (connection == summary_.connections.end()) {
      if (orphans_.size() < connection_limit) ++orphans_[id];
      return;
    }
    data_.resize(static_cast<std::size_t>(record.data_size));
    source.read(record.data_begin, data_.size(), data_.data());
    const std::uint64_t stored = field_u64(record.fields, "time").value_or(0);
    BagMessage message;
    message.connection = &connection->second;
    message.time = (stored & 0xffffffffU) * 1000000000ULL + (stored >> 32);
    message.data = data_.data();
    message.size = data_.size();
    ++summary_.messages;
    visit_(message);
  }

  /// Reads the chunk and returns where the next record is expected.
  std::uint64_t read_chunk(const Record& record) {
    ++summary_.chunks;
    const std::string compression = field_text(record.fields, "compression");
    if (compression == "none") {
      summary_.has_uncompressed_chunks = true;
      if (record.data_size == 0 && record.data_begin < source_.size())
        damage(record.begin, "an unfinished chunk: the recorder was killed");
      else if (record.data_end() > source_.size())
        damage(record.begin, "the file ends within a chunk");
      return record.data_begin;  // its records follow in place, each readable on its own
    }
    const std::uint32_t claimed = field_u32(record.fields, "size").value_or(0);
    const bool unfinished = record.data_size == 0 || record.data_end() > source_.size();
    const std::uint64_t end = unfinished ? source_.size() : record.data_end();
    const Decompressed chunk = decompress(source_, record.data_begin, end, compression, claimed);
    using State = Decompressed::State;
    const bool whole = chunk.state == State::whole;
    if (record.data_size == 0)
      damage(record.begin, fmt::format("an unfinished {} chunk: the recorder was killed", compression));
    else if (chunk.state == State::cut && unfinished)
      damage(record.begin, fmt::format("the file ends within a {} chunk", compression));
    else if (chunk.state == State::unknown)
      damage(record.begin, fmt::format("a chunk of the unknown compression '{:.20}' is lost", compression));
    else if (chunk.state == State::too_large)
      damage(record.begin,
             fmt::format("a {} chunk of more than {} MiB is not read", compression, chunk_limit >> 20));
    else if (!whole)
      damage(record.begin, fmt::format("a {} chunk is damaged and lost", compression));
    if (chunk.bytes.empty())
      ++summary_.lost_chunks;
    else {
      chunk_offset_ = record.begin;
      MemorySource bytes(chunk.bytes.data(), chunk.bytes.size());
      walk(bytes, 0, false);
    }
    if (whole && unfinished) return record.data_begin + chunk.consumed;
    if (!unfinished && follows(source_, record.data_end())) return record.data_end();
    return find_record(source_, record.data_begin);
  }

  ByteSource& source_;
  const BagVisitor& visit_;
  ScanSummary summary_;
  std::map<std::uint32_t, std::uint64_t> orphans_;
  std::vector<std::uint8_t> data_;
  std::uint64_t chunk_offset_ = 0;
};

}  // namespace

ScanSummary scan_bag(ByteSource& source, const std::string& name, const BagVisitor& visit) {
  return Scanner(source, visit).scan(name);
}

ScanSummary scan_bag(const std::string& path, const BagVisitor& visit) {
  FileSource source(path);
  return scan_bag(source, path, visit);
}

}  // namespace wheel_twin::logs
