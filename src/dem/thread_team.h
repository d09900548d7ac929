// A fixed team of threads that runs one job after another with little delay: members spin a while, then
// sleep.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace wheel_twin::dem {

class ThreadTeam {
 public:
  explicit ThreadTeam(std::size_t size);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  std::size_t size() const { return members_.size() + 1; }
  /// Runs job(0) to job(size - 1) at once and waits for all; rethrows the first exception in the order of the
  /// members.
  void run(const std::function<void(std::size_t)>& job);

 private:
  void work(std::size_t member);

  std::vector<std::thread> members_;
  std::vector<std::exception_ptr> failures_;
  const std::function<void(std::size_t)>* job_ = nullptr;
  std::atomic<std::uint64_t> round_{0};
  std::atomic<std::size_t> left_{0};
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::condition_variable wake_;
};

}  // namespace wheel_twin::dem
