#include "logs/byte_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/error.h"

namespace wheel_twin::logs {
namespace {
constexpr std::size_t window_bytes = 1UL << 18;  // 256 KiB
}

FileSource::FileSource(std::string path) : path_(std::move(path)) {
  file_ = open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) throw Error(fmt::format("{}: cannot be opened: {}", path_, std::strerror(errno)));
  struct stat status {};
  if (fstat(file_, &status) != 0 || !S_ISREG(status.st_mode)) {
    close(file_);
    throw Error(fmt::format("{}: is not a file", path_));
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

FileSource::~FileSource() {
  close(file_);
}

std::size_t FileSource::read_at(std::uint64_t offset, std::size_t count, char* destination) const {
  std::size_t done = 0;
  while (done < count) {
    const ssize_t got = pread(file_, destination + done, count - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      throw Error(
          fmt::format("{}: cannot be read at byte {}: {}", path_, offset + done, std::strerror(errno)));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

bool FileSource::read(std::uint64_t offset, std::size_t count, void* destination) {
  if (offset > size_ || count > size_ - offset) return false;
  if (count > window_bytes) return read_at(offset, count, static_cast<char*>(destination)) == count;
  if (offset < window_begin_ || offset + count > window_begin_ + window_.size()) {
    window_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(window_bytes, size_ - offset)));
    window_begin_ = offset;
    window_.resize(read_at(offset, window_.size(), window_.data()));
    if (window_.size() < count) return false;
  }
  std::memcpy(destination, window_.data() + (offset - window_begin_), count);
  return true;
}

bool MemorySource::read(std::uint64_t offset, std::size_t count, void* destination) {
  if (offset > size_ || count > size_ - offset) return false;
  std::copy_n(data_ + offset, count, static_cast<std::uint8_t*>(destination));
  return true;
}

}  // namespace wheel_twin::logs
