#include "dem/thread_team.h"

namespace wheel_twin::dem {
namespace {

constexpr int kSpins = 1000;  // pauses of 15 to 40 ns each

void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

template <class Condition>
void ThreadTeam::Signal::wait(int spins, const Condition& condition) {
  for (int spin = 0; spin < spins; ++spin) {
    if (condition()) return;
    pause();
  }
  std::unique_lock<std::mutex> lock(mutex_);
  ++sleeping_;
  changed_.wait(lock, condition);
  --sleeping_;
}

// Either this sees the sleeper, or the sleeper, which counted itself first, sees the change.
void ThreadTeam::Signal::notify() {
  if (sleeping_ == 0) return;
  { const std::lock_guard<std::mutex> lock(mutex_); }
  changed_.notify_all();
}

ThreadTeam::ThreadTeam(std::size_t size) : claimed_(size), failures_(size) {
  const std::size_t processors = std::thread::hardware_concurrency();
  spins_ = processors == 0 || size <= processors ? kSpins : 0;
  for (std::size_t m = 1; m < size; ++m) members_.emplace_back([this, m] { work(m); });
}

ThreadTeam::~ThreadTeam() {
  stop_ = true;
  ++round_;
  begun_.notify();
  for (auto& member : members_) member.join();
}

void ThreadTeam::run(const std::function<void(std::size_t)>& job) {
  if (members_.empty()) {
    job(0);
    return;
  }
  job_ = &job;
  left_ = size();
  const std::uint64_t round = ++round_;
  begun_.notify();
  take_parts(0, round);
  done_.wait(spins_, [this] { return left_ == 0; });
  for (auto& failure : failures_) {
    if (!failure) continue;
    const std::exception_ptr first = failure;
    for (auto& each : failures_) each = nullptr;
    std::rethrow_exception(first);
  }
}

void ThreadTeam::take_parts(std::size_t member, std::uint64_t round) {
  for (std::size_t k = 0; k < size(); ++k) {
    const std::size_t part = (member + k) % size();
    // A part of this round can be taken only while run() waits for it: the job is there.
    std::uint64_t before = round - 1;
    if (!claimed_[part].compare_exchange_strong(before, round)) continue;
    try {
      (*job_)(part);
    } catch (...) {
      failures_[part] = std::current_exception();
    }
    if (--left_ == 0) done_.notify();
  }
}

void ThreadTeam::work(std::size_t member) {
  std::uint64_t seen = 0;
  for (;;) {
    begun_.wait(spins_, [&] { return round_ != seen; });
    seen = round_;
    if (stop_) return;
    take_parts(member, seen);
  }
}

}  // namespace wheel_twin::dem
