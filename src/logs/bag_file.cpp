#include "logs/bag_file.h"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "logs/bag_record.h"

namespace wheel_twin::logs {
namespace {

constexpr char version_line[] = "#ROSBAG V2.0\n";
constexpr std::size_t bag_header_size = 4096;
// rosbag's default is 768 KiB; less is lost with a smaller one when a recorder is killed.
constexpr std::size_t chunk_threshold = 1UL << 18;  // 256 KiB

template <typename T>
std::string little(T value) {
  std::string bytes(sizeof(T), '\0');
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes[i] = static_cast<char>(value >> (8 * i) & 0xff);
  return bytes;
}

std::string little_time(std::uint64_t time) {
  return little(static_cast<std::uint32_t>(time / 1000000000)) +
         little(static_cast<std::uint32_t>(time % 1000000000));
}

std::string fields_text(const Fields& fields) {
  std::string text;
  for (const auto& [name, value] : fields) {
    text += little(static_cast<std::uint32_t>(name.size() + 1 + value.size()));
    text += name;
    text += '=';
    text += value;
  }
  return text;
}

std::string record_text(Op op, Fields fields, const std::string& data) {
  fields["op"] = std::string(1, static_cast<char>(op));
  const std::string header = fields_text(fields);
  return little(static_cast<std::uint32_t>(header.size())) + header +
         little(static_cast<std::uint32_t>(data.size())) + data;
}

std::string bag_header(std::uint64_t index_position, std::size_t connections, std::size_t chunks) {
  Fields fields{{"index_pos", little(index_position)},
                {"conn_count", little(static_cast<std::uint32_t>(connections))},
                {"chunk_count", little(static_cast<std::uint32_t>(chunks))}};
  const std::size_t used = record_text(Op::bag_header, fields, "").size() - 8;
  return record_text(Op::bag_header, std::move(fields), std::string(bag_header_size - used, ' '));
}

std::string compress_bz2(const std::string& chunk) {
  auto size = static_cast<unsigned int>(chunk.size() + chunk.size() / 100 + 600);
  std::string out(size, '\0');
  // libbz2 only reads the input.
  const int code = BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(chunk.data()),
                                            static_cast<unsigned int>(chunk.size()), 9, 0, 30);
  if (code != BZ_OK) throw Error(fmt::format("bz2 cannot compress a chunk (code {})", code));
  out.resize(size);
  return out;
}

/// The frame that rosbag's lz4 reader expects: independent blocks, a checksum of the content, no sizes.
std::string compress_lz4(const std::string& chunk) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockMode = LZ4F_blockIndependent;
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  preferences.frameInfo.blockSizeID = LZ4F_max1MB;
  std::string out(LZ4F_compressFrameBound(chunk.size(), &preferences), '\0');
  const std::size_t size =
      LZ4F_compressFrame(out.data(), out.size(), chunk.data(), chunk.size(), &preferences);
  if (LZ4F_isError(size) != 0)
    throw Error(fmt::format("lz4 cannot compress a chunk: {}", LZ4F_getErrorName(size)));
  out.resize(size);
  return out;
}

const char* name_of(Compression compression) {
  switch (compression) {
    case Compression::none:
      return "none";
    case Compression::bz2:
      return "bz2";
    case Compression::lz4:
      break;
  }
  return "lz4";
}

}  // namespace

BagFile::BagFile(const std::string& path, std::string name, Compression compression)
    : name_(std::move(name)), compression_(compression), file_(std::fopen(path.c_str(), "wbe")) {
  if (file_ == nullptr) fail();
  put(version_line);
  put(bag_header(0, 0, 0));
  std::fflush(file_.get());
}

BagFile::~BagFile() {
  try {
    close();
  } catch (const Error&) {
    file_.reset();
  }
}

void BagFile::fail() const {
  throw Error(fmt::format("{}: cannot be written: {}", name_, std::strerror(errno)));
}

void BagFile::put(const std::string& bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) fail();
  position_ += bytes.size();
}

std::uint32_t BagFile::add_connection(const std::string& topic,
                                      const std::map<std::string, std::string>& header) {
  const auto id = static_cast<std::uint32_t>(connections_.size());
  connections_.push_back(
      record_text(Op::connection, {{"conn", little(id)}, {"topic", topic}}, fields_text(header)));
  return id;
}

void BagFile::write(std::uint32_t connection, std::uint64_t time, const std::uint8_t* data,
                    std::size_t size) {
  if (chunk_.empty()) {
    current_.position = position_;
    current_.start = time;
    current_.end = time;
  }
  auto& entries = entries_[connection];
  if (entries.empty()) chunk_ += connections_.at(connection);
  entries.push_back({time, static_cast<std::uint32_t>(chunk_.size())});
  current_.start = std::min(current_.start, time);
  current_.end = std::max(current_.end, time);
  // The header of a message record, written out: it is the same for all but the numbers.
  static const std::string before_connection =
      little<std::uint32_t>(9 + 4 + 4 + 4 + 13 + 4) + little<std::uint32_t>(9) + "conn=";
  static const std::string before_time =
      little<std::uint32_t>(4) + "op=\x02" + little<std::uint32_t>(13) + "time=";
  chunk_ += before_connection;
  chunk_ += little(connection);
  chunk_ += before_time;
  chunk_ += little_time(time);
  chunk_ += little(static_cast<std::uint32_t>(size));
  chunk_.append(reinterpret_cast<const char*>(data), size);
  if (chunk_.size() > chunk_threshold) finish_chunk();
}

void BagFile::finish_chunk() {
  if (chunk_.empty()) return;
  std::string data;
  if (compression_ == Compression::bz2)
    data = compress_bz2(chunk_);
  else if (compression_ == Compression::lz4)
    data = compress_lz4(chunk_);
  put(record_text(
      Op::chunk,
      {{"compression", name_of(compression_)}, {"size", little(static_cast<std::uint32_t>(chunk_.size()))}},
      compression_ == Compression::none ? chunk_ : data));
  for (const auto& [connection, entries] : entries_) {
    std::string index;
    index.reserve(12 * entries.size());
    for (const Entry& entry : entries) {
      index += little_time(entry.time);
      index += little(entry.offset);
    }
    put(record_text(Op::index,
                    {{"ver", little<std::uint32_t>(1)},
                     {"conn", little(connection)},
                     {"count", little(static_cast<std::uint32_t>(entries.size()))}},
                    index));
    current_.counts[connection] = static_cast<std::uint32_t>(entries.size());
  }
  if (std::fflush(file_.get()) != 0) fail();
  chunks_.push_back(std::move(current_));
  current_ = {};
  entries_.clear();
  chunk_.clear();
}

void BagFile::close() {
  if (file_ == nullptr) return;
  finish_chunk();
  const std::uint64_t index_position = position_;
  for (const std::string& connection : connections_) put(connection);
  for (const ChunkInfo& chunk : chunks_) {
    std::string counts;
    for (const auto& [connection, count] : chunk.counts) counts += little(connection) + little(count);
    put(record_text(Op::chunk_info,
                    {{"ver", little<std::uint32_t>(1)},
                     {"chunk_pos", little(chunk.position)},
                     {"start_time", little_time(chunk.start)},
                     {"end_time", little_time(chunk.end)},
                     {"count", little(static_cast<std::uint32_t>(chunk.counts.size()))}},
                    counts));
  }
  if (std::fseek(file_.get(), sizeof(version_line) - 1, SEEK_SET) != 0) fail();
  put(bag_header(index_position, connections_.size(), chunks_.size()));
  if (std::fclose(file_.release()) != 0) fail();
}

}  // namespace wheel_twin::logs
