#include "logs/chunk.h"

#include <bzlib.h>
#include <lz4frame.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

namespace wheel_twin::logs {
namespace {

using State = Decompressed::State;

constexpr std::size_t first_output = 1 << 20;
constexpr std::size_t input_block = 1UL << 16;

/// Reads the input in blocks.
class Input {
 public:
  Input(ByteSource& source, std::uint64_t begin, std::uint64_t end)
      : source_(source), next_(begin), end_(end) {}

  /// Bytes of the next block, 0 at the end.
  std::size_t refill() {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(block_.size(), end_ - next_));
    if (count == 0 || !source_.read(next_, count, block_.data())) return 0;
    next_ += count;
    return count;
  }
  char* data() { return block_.data(); }
  std::uint64_t position() const { return next_; }

 private:
  ByteSource& source_;
  std::uint64_t next_;
  std::uint64_t end_;
  std::array<char, input_block> block_{};
};

Decompressed failed(State state) {
  Decompressed result;
  result.state = state;
  return result;
}

/// Room for what comes out, doubled as it fills.
class Output {
 public:
  explicit Output(std::uint64_t expected) : first_(std::clamp<std::uint64_t>(expected, 4096, first_output)) {}

  /// False when the limit is reached.
  bool make_room() {
    if (size_ < result_.bytes.size()) return true;
    if (size_ >= chunk_limit) return false;
    result_.bytes.resize(static_cast<std::size_t>(
        std::min<std::uint64_t>(std::max<std::uint64_t>(first_, 2 * size_), chunk_limit)));
    return true;
  }
  std::uint8_t* next() { return result_.bytes.data() + size_; }
  std::size_t room() const { return result_.bytes.size() - size_; }
  void advance(std::size_t count) { size_ += count; }

  Decompressed finish(State state, std::uint64_t consumed) {
    result_.bytes.resize(size_);
    result_.state = state;
    result_.consumed = consumed;
    return std::move(result_);
  }

 private:
  Decompressed result_;
  std::uint64_t first_;
  std::size_t size_ = 0;
};

Decompressed decompress_bz2(ByteSource& source, std::uint64_t begin, std::uint64_t end,
                            std::uint64_t expected) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return failed(State::damaged);
  const std::unique_ptr<bz_stream, int (*)(bz_stream*)> guard(&stream, BZ2_bzDecompressEnd);
  const auto input = std::make_unique<Input>(source, begin, end);
  Output output(expected);
  for (;;) {
    if (stream.avail_in == 0) {
      stream.next_in = input->data();
      stream.avail_in = static_cast<unsigned int>(input->refill());
    }
    if (!output.make_room()) return failed(State::too_large);
    const bool starved = stream.avail_in == 0;
    const auto room = static_cast<unsigned int>(output.room());
    stream.next_out = reinterpret_cast<char*>(output.next());
    stream.avail_out = room;
    const int code = BZ2_bzDecompress(&stream);
    output.advance(room - stream.avail_out);
    if (code == BZ_STREAM_END)
      return output.finish(State::whole, input->position() - begin - stream.avail_in);
    if (code != BZ_OK) return failed(State::damaged);
    if (starved && stream.avail_out == room) return output.finish(State::cut, end - begin);
  }
}

Decompressed decompress_lz4(ByteSource& source, std::uint64_t begin, std::uint64_t end,
                            std::uint64_t expected) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0)
    return failed(State::damaged);
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> guard(context,
                                                                           LZ4F_freeDecompressionContext);
  const auto input = std::make_unique<Input>(source, begin, end);
  Output output(expected);
  std::size_t available = 0;
  std::size_t used = 0;
  for (;;) {
    if (used == available) {
      available = input->refill();
      used = 0;
    }
    if (!output.make_room()) return failed(State::too_large);
    std::size_t taken = available - used;
    std::size_t given = output.room();
    const std::size_t code =
        LZ4F_decompress(context, output.next(), &given, input->data() + used, &taken, nullptr);
    if (LZ4F_isError(code) != 0) return failed(State::damaged);
    used += taken;
    output.advance(given);
    if (code == 0) return output.finish(State::whole, input->position() - begin - (available - used));
    if (available == 0 && given == 0) return output.finish(State::cut, end - begin);
  }
}

}  // namespace

Decompressed decompress(ByteSource& source, std::uint64_t begin, std::uint64_t end,
                        const std::string& compression, std::uint64_t expected) {
  if (compression == "bz2") return decompress_bz2(source, begin, end, expected);
  if (compression != "lz4") return failed(State::unknown);
  return decompress_lz4(source, begin, end, expected);
}

}  // namespace wheel_twin::logs
