// Named arrays, numbers and texts: the complete state of a granular system, as a file keeps it. HDF5, one
// dataset an array, written whole or not at all; a SHA-256 over all content tells a damaged file from a good
// one.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace wheel_twin::dem {

/// A row-major table of `columns` columns.
struct Array {
  using Data =
      std::variant<std::vector<double>, std::vector<float>, std::vector<std::int32_t>,
                   std::vector<std::uint32_t>, std::vector<std::int64_t>, std::vector<std::uint64_t>>;
  Data data;
  std::size_t columns = 1;
};

class Archive {
 public:
  template <typename T>
  void set(const std::string& name, std::vector<T> values, std::size_t columns = 1) {
    arrays_[name] = Array{std::move(values), columns};
  }
  void set_number(const std::string& name, double value) { numbers_[name] = value; }
  void set_text(const std::string& name, const std::string& value) { texts_[name] = value; }

  /// Throws Error naming the file and the entry when it is missing or of another type.
  template <typename T>
  const std::vector<T>& get(const std::string& name) const {
    const auto found = arrays_.find(name);
    if (found == arrays_.end()) fail(name, "is missing");
    const auto* values = std::get_if<std::vector<T>>(&found->second.data);
    if (values == nullptr) fail(name, "has another type than expected");
    return *values;
  }
  double number(const std::string& name) const;
  const std::string& text(const std::string& name) const;
  bool has(const std::string& name) const { return arrays_.count(name) > 0; }
  bool has_number(const std::string& name) const { return numbers_.count(name) > 0; }
  bool has_text(const std::string& name) const { return texts_.count(name) > 0; }

  const std::map<std::string, Array>& arrays() const { return arrays_; }
  const std::map<std::string, double>& numbers() const { return numbers_; }
  const std::map<std::string, std::string>& texts() const { return texts_; }

  /// SHA-256 (hex) over names, shapes and bits of everything inside.
  std::string hash() const;

 private:
  friend class ArchiveReader;
  [[noreturn]] void fail(const std::string& name, const std::string& message) const;

  std::string source_ = "archive";
  std::map<std::string, Array> arrays_;
  std::map<std::string, double> numbers_;
  std::map<std::string, std::string> texts_;
};

/// Layout of the files; a file of another version is refused.
constexpr int archive_version = 1;

/// Writes `archive` to `path` atomically and durably (the old file stays until the new one is on disk).
/// `kind` says what it holds, "bed" or "checkpoint". Throws Error naming the file.
void write_archive(const std::string& path, const std::string& kind, const Archive& archive);

/// Reads it back. Throws Error naming the file when it is missing, not HDF5, cut short, damaged, of another
/// kind or of another version.
Archive read_archive(const std::string& path, const std::string& kind);

/// The same file in memory, for a message.
std::vector<std::uint8_t> archive_bytes(const std::string& kind, const Archive& archive);
/// Reads it back; `source` stands for the file in errors.
Archive archive_from_bytes(const std::vector<std::uint8_t>& bytes, const std::string& kind,
                           const std::string& source);

/// SHA-256 of a text, hex.
std::string sha256(const std::string& text);

}  // namespace wheel_twin::dem
