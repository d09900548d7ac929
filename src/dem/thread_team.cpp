#include "dem/thread_team.h"

namespace wheel_twin::dem {
namespace {
constexpr int kSpins = 20000;
}

ThreadTeam::ThreadTeam(std::size_t size) : failures_(size) {
  for (std::size_t m = 1; m < size; ++m) members_.emplace_back([this, m] { work(m); });
}

ThreadTeam::~ThreadTeam() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
    ++round_;
  }
  wake_.notify_all();
  for (auto& member : members_) member.join();
}

void ThreadTeam::run(const std::function<void(std::size_t)>& job) {
  if (members_.empty()) {
    job(0);
    return;
  }
  job_ = &job;
  left_ = members_.size();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++round_;
  }
  wake_.notify_all();
  try {
    job(0);
  } catch (...) {
    failures_[0] = std::current_exception();
  }
  while (left_.load(std::memory_order_acquire) != 0) std::this_thread::yield();
  for (auto& failure : failures_) {
    if (!failure) continue;
    const std::exception_ptr first = failure;
    for (auto& each : failures_) each = nullptr;
    std::rethrow_exception(first);
  }
}

void ThreadTeam::work(std::size_t member) {
  std::uint64_t seen = 0;
  for (;;) {
    for (int spin = 0; spin < kSpins && round_.load(std::memory_order_acquire) == seen; ++spin) {
    }
    if (round_.load(std::memory_order_acquire) == seen) {
      std::unique_lock<std::mutex> lock(mutex_);
      wake_.wait(lock, [&] { return round_.load() != seen; });
    }
    seen = round_.load(std::memory_order_acquire);
    if (stop_) return;
    try {
      (*job_)(member);
    } catch (...) {
      failures_[member] = std::current_exception();
    }
    left_.fetch_sub(1, std::memory_order_release);
  }
}

}  // namespace wheel_twin::dem
