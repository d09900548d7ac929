// How the chunks of a bag are compressed. An uncompressed chunk has no checksum.
#pragma once

namespace wheel_twin::logs {

enum class Compression { none, bz2, lz4 };

}  // namespace wheel_twin::logs
