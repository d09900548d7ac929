// A fixed team of threads that runs one job after another with little delay. Each member takes its own part
// of a job; who is done takes parts that nobody has begun, so that a member that the system does not run (a
// shared machine) holds nobody up. Who waits spins for some microseconds, then sleeps.
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

  std::size_t size() const { return claimed_.size(); }
  /// Runs job(0) to job(size - 1) at once and waits for all; rethrows the first exception in the order of the
  /// parts.
  void run(const std::function<void(std::size_t)>& job);

 private:
  /// Something to wait for: whoever changes what a condition reads calls notify().
  class Signal {
   public:
    template <class Condition>
    void wait(int spins, const Condition& condition);
    void notify();

   private:
    std::mutex mutex_;
    std::condition_variable changed_;
    std::atomic<int> sleeping_{0};
  };

  void work(std::size_t member);
  void take_parts(std::size_t member, std::uint64_t round);

  std::vector<std::atomic<std::uint64_t>> claimed_;  ///< by part: the round in which it was taken last
  std::vector<std::exception_ptr> failures_;         ///< by part
  std::vector<std::thread> members_;
  int spins_ = 0;
  const std::function<void(std::size_t)>* job_ = nullptr;
  std::atomic<std::uint64_t> round_{0};
  std::atomic<std::size_t> left_{0};
  std::atomic<bool> stop_{false};
  Signal begun_, done_;
};

}  // namespace wheel_twin::dem
