// Decompression of the chunks of a bag (bz2 and lz4) that trusts no length: memory grows with what really
// comes out, up to a limit (lz4 through liblz4's frame format: roslz4 believes the length of a block). Both
// formats carry a checksum, so what is returned as whole is what was recorded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "logs/byte_source.h"

namespace wheel_twin::logs {

/// Bytes that one chunk may hold, 128 MiB: a rig's recorder writes chunks of 0.75 MiB, one large point cloud
/// a few.
inline constexpr std::uint64_t chunk_limit = 128ULL << 20;

struct Decompressed {
  enum class State {
    whole,      ///< end of the stream reached, checksum right
    cut,        ///< the input ended early; `bytes` is what stood before
    damaged,    ///< wrong data or checksum; `bytes` is empty
    too_large,  ///< more than chunk_limit; `bytes` is empty
    unknown     ///< no such compression; `bytes` is empty
  };
  State state = State::unknown;
  std::vector<std::uint8_t> bytes;
  std::uint64_t consumed = 0;  ///< of the input
};

/// Decompresses [begin, end) of `source`; `compression` is "bz2" or "lz4", `expected` the size that the bag
/// claims (0: not known) and only saves time when it is right.
Decompressed decompress(ByteSource& source, std::uint64_t begin, std::uint64_t end,
                        const std::string& compression, std::uint64_t expected);

}  // namespace wheel_twin::logs
