#include "dem/store.h"

#include <sys/mman.h>

#include <new>

namespace wheel_twin::dem {
namespace {

constexpr std::size_t kPage = std::size_t{1} << 21U;

std::align_val_t alignment_of(std::size_t bytes) {
  return std::align_val_t{bytes < 2 * kPage ? 64 : kPage};
}

}  // namespace

void* take(std::size_t bytes) {
  void* block = ::operator new(bytes, alignment_of(bytes));
  // A wish: without large pages everything works, a bed of a million spheres at half the speed.
  if (bytes >= 2 * kPage) madvise(block, bytes, MADV_HUGEPAGE);
  return block;
}

void release(void* block, std::size_t bytes) {
  ::operator delete(block, alignment_of(bytes));
}

}  // namespace wheel_twin::dem
