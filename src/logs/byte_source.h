// Bytes at an offset, of a file (through one window, so that a file of any size needs little memory) or of
// memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace wheel_twin::logs {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::uint64_t size() const = 0;
  /// Copies [offset, offset + count) to `destination`; false, and nothing useful copied, where that passes
  /// the end.
  virtual bool read(std::uint64_t offset, std::size_t count, void* destination) = 0;
};

/// Reads a regular file. Its size is that at opening: a file that still grows is read up to there.
class FileSource : public ByteSource {
 public:
  explicit FileSource(std::string path);  ///< throws Error when it cannot be opened or is no regular file
  ~FileSource() override;
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;
  std::uint64_t size() const override { return size_; }
  bool read(std::uint64_t offset, std::size_t count, void* destination) override;

 private:
  std::size_t read_at(std::uint64_t offset, std::size_t count, char* destination) const;

  std::string path_;
  int file_ = -1;
  std::uint64_t size_ = 0;
  std::uint64_t window_begin_ = 0;
  std::vector<char> window_;
};

/// Bytes owned by someone else.
class MemorySource : public ByteSource {
 public:
  MemorySource(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  std::uint64_t size() const override { return size_; }
  bool read(std::uint64_t offset, std::size_t count, void* destination) override;

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

}  // namespace wheel_twin::logs
