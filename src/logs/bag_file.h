// Writes a bag of format 2.0 (wiki.ros.org/Bags/Format/2.0) message by message: what rosbag::Bag does,
// without its six system calls a message (a run at 1 kHz takes a tenth of the time), and with the connections
// described again in every chunk, so that each chunk can be read alone. A chunk goes to the file whole, when
// it is full.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "logs/compression.h"

namespace wheel_twin::logs {

class BagFile {
 public:
  /// `name` stands for the file in errors. Throws Error when `path` cannot be created.
  BagFile(const std::string& path, std::string name, Compression compression);
  ~BagFile();  ///< closes; an error is lost: call close()
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;

  /// A new connection. `header` has at least type, md5sum and message_definition. Returns its number.
  std::uint32_t add_connection(const std::string& topic, const std::map<std::string, std::string>& header);

  /// Appends a serialized message. `time`: bag time in ns; rosbag does not read messages of time 0. Throws
  /// Error when the file cannot be written.
  void write(std::uint32_t connection, std::uint64_t time, const std::uint8_t* data, std::size_t size);

  void close();  ///< writes the index; throws Error when the file cannot be written; further calls do nothing

 private:
  struct Entry {
    std::uint64_t time;
    std::uint32_t offset;
  };
  struct ChunkInfo {
    std::uint64_t position = 0;
    std::uint64_t start = 0;
    std::uint64_t end = 0;
    std::map<std::uint32_t, std::uint32_t> counts;
  };
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  void put(const std::string& bytes);
  void finish_chunk();
  [[noreturn]] void fail() const;

  std::string name_;
  Compression compression_;
  std::unique_ptr<std::FILE, Close> file_;
  std::uint64_t position_ = 0;
  std::vector<std::string> connections_;  // their records
  std::vector<ChunkInfo> chunks_;
  std::string chunk_;  // uncompressed
  ChunkInfo current_;
  std::map<std::uint32_t, std::vector<Entry>> entries_;
};

}  // namespace wheel_twin::logs
