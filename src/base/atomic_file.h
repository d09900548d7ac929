// Outputs appear whole or not at all: they are written to a temporary name beside the target and renamed.
#pragma once

#include <string>

namespace wheel_twin {

/// A temporary name beside `target`; commit() renames it to `target`, destruction without commit removes it.
class AtomicFile {
 public:
  explicit AtomicFile(std::string target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  const std::string& path() const { return temporary_; }  ///< write here
  void commit();                                          ///< throws Error when the rename fails

 private:
  std::string target_;
  std::string temporary_;
  bool committed_ = false;
};

/// Writes `content` to `target` atomically. Throws Error naming the file.
void write_file(const std::string& target, const std::string& content);

}  // namespace wheel_twin
