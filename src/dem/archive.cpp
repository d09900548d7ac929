#include "dem/archive.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <memory>

#include "base/error.h"

namespace wheel_twin::dem {
namespace {

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1)
      throw Error("SHA-256 is not available");
  }
  void add(const void* data, std::size_t size) { EVP_DigestUpdate(context_.get(), data, size); }
  void add(const std::string& text) {
    const std::uint64_t size = text.size();
    add(&size, sizeof size);
    add(text.data(), text.size());
  }
  std::string hex() {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    EVP_DigestFinal_ex(context_.get(), digest, &size);
    std::string result;
    for (unsigned int i = 0; i < size; ++i) result += fmt::format("{:02x}", digest[i]);
    return result;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::string sha256(const std::string& text) {
  Sha256 hash;
  hash.add(text.data(), text.size());
  return hash.hex();
}

std::string Archive::hash() const {
  Sha256 hash;
  for (const auto& [name, array] : arrays_) {
    hash.add(name);
    const std::uint64_t shape[2] = {array.data.index(), array.columns};
    hash.add(shape, sizeof shape);
    std::visit(
        [&](const auto& values) {
          const std::uint64_t size = values.size();
          hash.add(&size, sizeof size);
          hash.add(values.data(), values.size() * sizeof(values[0]));
        },
        array.data);
  }
  for (const auto& [name, value] : numbers_) {
    hash.add(name);
    hash.add(&value, sizeof value);
  }
  for (const auto& [name, value] : texts_) {
    hash.add(name);
    hash.add(value);
  }
  return hash.hex();
}

double Archive::number(const std::string& name) const {
  const auto found = numbers_.find(name);
  if (found == numbers_.end()) fail(name, "is missing");
  return found->second;
}

const std::string& Archive::text(const std::string& name) const {
  const auto found = texts_.find(name);
  if (found == texts_.end()) fail(name, "is missing");
  return found->second;
}

void Archive::fail(const std::string& name, const std::string& message) const {
  throw Error(fmt::format("{}: {}: {}", source_, name, message));
}

}  // namespace wheel_twin::dem
