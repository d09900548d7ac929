// Strict reading of YAML: every key is known, present once, of the right type and in range, or the error
// names file, line and key. Avoids YAML's traps: `010` (octal), `on` (boolean), doubled keys, empty values,
// quoted numbers. A key is consumed by reading it; finish() refuses the keys that nobody read.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace wheel_twin::yaml {

/// Closed interval a number must lie in. Non-finite numbers are never in range.
struct Range {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
};
inline Range positive() {
  return {std::numeric_limits<double>::min(), std::numeric_limits<double>::max()};
}
inline Range non_negative() {
  return {0.0, std::numeric_limits<double>::max()};
}

class List;

/// A mapping. Copies share what has been read. All getters throw Error as described above.
class Map {
 public:
  bool has(const std::string& key) const;      ///< present, null included
  bool is_null(const std::string& key) const;  ///< present and `null` or `~`
  bool is_map(const std::string& key) const;
  bool is_list(const std::string& key) const;
  std::vector<std::string> keys() const;

  double number(const std::string& key, Range range = {}) const;
  double number_or(const std::string& key, double fallback, Range range = {}) const;
  /// `null` and absence give nothing.
  std::optional<double> optional_number(const std::string& key, Range range = {}) const;
  std::int64_t integer(const std::string& key,
                       std::int64_t minimum = std::numeric_limits<std::int64_t>::min(),
                       std::int64_t maximum = std::numeric_limits<std::int64_t>::max()) const;
  std::int64_t integer_or(const std::string& key, std::int64_t fallback,
                          std::int64_t minimum = std::numeric_limits<std::int64_t>::min(),
                          std::int64_t maximum = std::numeric_limits<std::int64_t>::max()) const;
  bool boolean(const std::string& key) const;
  bool boolean_or(const std::string& key, bool fallback) const;
  std::string text(const std::string& key) const;
  std::string text_or(const std::string& key, const std::string& fallback) const;
  std::vector<double> numbers(const std::string& key,
                              Range range = {}) const;  ///< a list of numbers, any length
  Map map(const std::string& key) const;
  std::optional<Map> optional_map(const std::string& key) const;
  List list(const std::string& key) const;

  void skip(const std::string& key) const;  ///< accept a key that another layer reads
  void finish() const;                      ///< refuse keys that nobody read

  /// "file:line: key: message" for errors about a value that was read but makes no sense together with
  /// others.
  [[noreturn]] void fail(const std::string& key, const std::string& message) const;
  const std::string& file() const;

 private:
  friend class List;
  friend Map parse_file(const std::string&);
  friend Map parse_text(const std::string&, const std::string&);
  struct Impl;
  explicit Map(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<Impl> impl_;
};

/// A sequence of mappings, numbers or texts.
class List {
 public:
  std::size_t size() const;
  Map map(std::size_t index) const;
  double number(std::size_t index, Range range = {}) const;
  std::string text(std::size_t index) const;

 private:
  friend class Map;
  struct Impl;
  explicit List(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<Impl> impl_;
};

/// Reads a file whose top level is a mapping. Throws Error when it is missing, not YAML or not a mapping.
Map parse_file(const std::string& path);
/// The same from memory; `name` stands for the file in messages.
Map parse_text(const std::string& text, const std::string& name);

}  // namespace wheel_twin::yaml
