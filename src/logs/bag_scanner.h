// Reads a bag of format 2.0 (wiki.ros.org/Bags/Format/2.0) from its first record to its last, without its
// index. No length in it is trusted; memory is bounded whatever the file says. Where a record is not
// readable, the scan goes on at the next one that is: a damaged compressed chunk (bz2, lz4) loses only
// itself, in an uncompressed chunk a damaged record only itself, and the unfinished chunk of a recorder that
// was killed gives what it holds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "logs/byte_source.h"

namespace wheel_twin::logs {

struct BagConnection {
  std::uint32_t id = 0;
  std::string topic;
  std::string type;
  std::string md5sum;
  std::string definition;                     ///< full text of the message definition
  std::map<std::string, std::string> header;  ///< all fields: also callerid, latching
};

/// One message as recorded; valid during the visit.
struct BagMessage {
  const BagConnection* connection = nullptr;
  std::uint64_t time = 0;  ///< bag (arrival) time, ns
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
};

struct BagDamage {
  std::uint64_t offset = 0;  ///< in the file
  std::string text;
};

struct ScanSummary {
  std::uint64_t file_size = 0;
  std::uint64_t messages = 0;  ///< visited
  std::uint64_t orphans = 0;   ///< messages whose connection is described nowhere: they cannot be read
  std::uint64_t chunks = 0;
  std::uint64_t lost_chunks = 0;         ///< compressed chunks of which nothing could be read
  std::uint64_t skipped_bytes = 0;       ///< passed over in search of the next record
  bool indexed = false;                  ///< closed by its recorder: the header names the place of an index
  bool has_uncompressed_chunks = false;  ///< these carry no checksum: a damaged value in them cannot be seen
  std::uint64_t damage_count = 0;
  std::vector<BagDamage> damage;  ///< the first 20
  std::map<std::uint32_t, BagConnection> connections;

  bool intact() const { return damage_count == 0 && indexed && orphans == 0; }
};

using BagVisitor = std::function<void(const BagMessage&)>;

/// Visits the messages of `source` in the order of the file. `name` is the file in errors. Throws Error when
/// the source is no bag of format 2.0 (empty, something else, another version, encrypted); anything else
/// wrong is in the summary.
ScanSummary scan_bag(ByteSource& source, const std::string& name, const BagVisitor& visit);
ScanSummary scan_bag(const std::string& path, const BagVisitor& visit);

}  // namespace wheel_twin::logs
