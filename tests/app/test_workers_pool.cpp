// Loops give the same chunks with any number of workers; jobs run once; helpers are never real-time threads.
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

#include "app/session/thread.h"
#include "app/session/workers_pool.h"
#include "sim/fem/model/box_model.h"
#include "sim/fem/preconditioner/cholesky.h"

namespace limberg {
namespace test_workers_pool {

/// A sum whose last bits depend on the order: chunks reduced in order.
double chunked_sum(Workers& w, size_t n, size_t grain) {
  std::vector<double> part((n + grain - 1) / grain);
  w.parallel_for(n, grain, [&](size_t b, size_t e) {
    double s = 0;
    for (size_t i = b; i < e; ++i) s += std::sin(double(i)) * 1e-3 + 1.0 / double(i + 1);
    part[b / grain] = s;
  });
  double s = 0;
  for (const double p : part) s += p;
  return s;
}

TEST(WorkersPool, SameBitsWithAnyNumberOfWorkers) {
  InlineWorkers one;
  for (const int n : {1, 2, 3, 5}) {
    WorkersPool pool(n);
    EXPECT_EQ(pool.count(), n);
    for (const size_t size : {size_t(0), size_t(1), size_t(7), size_t(1000), size_t(100'003)})
      for (const size_t grain : {size_t(1), size_t(64), size_t(4096)}) {
        if (size / grain > 20'000) continue;
        EXPECT_EQ(chunked_sum(pool, size, grain), chunked_sum(one, size, grain)) << n << " " << size << " " << grain;
      }
  }
}

TEST(WorkersPool, EveryIndexOnceOverManyShortLoops) {
  WorkersPool pool(3);
  std::vector<int> hit(997);
  for (int round = 0; round < 2000; ++round)
    pool.parallel_for(hit.size(), 50, [&](size_t b, size_t e) {
      for (size_t i = b; i < e; ++i) ++hit[i];
    });
  for (const int h : hit) EXPECT_EQ(h, 2000);
}

// A helper that is held up in the middle of a chunk: the caller
// goes on alone for a while, and comes back. Same bits always.
TEST(WorkersPool, AHelperThatIsHeldUpIsLeftOut) {
  InlineWorkers one;
  const double expected = chunked_sum(one, 5000, 100);
  WorkersPool pool(2);
  const auto caller = std::this_thread::get_id();
  for (int round = 0; round < 2000 && pool.pace().long_waits == 0; ++round) {
    std::atomic<bool> helper_came = false;
    pool.parallel_for(2, 1, [&](size_t, size_t) {
      if (std::this_thread::get_id() == caller)
        for (int i = 0; i < 1000 && !helper_came; ++i) std::this_thread::yield();  // leaves a chunk to the helper
      else
        helper_came = true, std::this_thread::sleep_for(std::chrono::milliseconds(30));
    });
  }
  ASSERT_GT(pool.pace().long_waits, 0u);
  const auto before = pool.pace();
  EXPECT_EQ(chunked_sum(pool, 5000, 100), expected);  // at once: nobody is asked
  EXPECT_GE(pool.pace().alone + pool.pace().shared, before.alone + before.shared + 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(25));
  EXPECT_EQ(chunked_sum(pool, 5000, 100), expected);
  EXPECT_GT(pool.pace().shared, before.shared);  // asked again
}

TEST(WorkersPool, JobsRunOnceAndMayUseLoops) {
  for (const int n : {1, 2, 3}) {
    WorkersPool pool(n);
    std::atomic<int> ran{0};
    std::vector<std::shared_ptr<Workers::Job>> jobs;
    double inner = 0;
    jobs.push_back(pool.submit([&] { inner = chunked_sum(pool, 10'000, 100), ++ran; }));
    for (int i = 0; i < 20; ++i) jobs.push_back(pool.submit([&] { ++ran; }));
    InlineWorkers one;
    EXPECT_EQ(chunked_sum(pool, 10'000, 100), chunked_sum(one, 10'000, 100));  // a loop beside the jobs
    for (const auto& j : jobs) j->wait();
    for (const auto& j : jobs) EXPECT_TRUE(j->done());
    EXPECT_EQ(ran, 21);
    EXPECT_EQ(inner, chunked_sum(one, 10'000, 100));
  }
}

TEST(WorkersPool, ErrorsReachWhoeverWaits) {
  for (const int n : {1, 3}) {
    WorkersPool pool(n);
    EXPECT_THROW(pool.parallel_for(100, 1,
                                   [](size_t b, size_t) {
                                     if (b == 57) throw std::runtime_error("57");
                                   }),
                 std::runtime_error);
    pool.parallel_for(10, 1, [](size_t, size_t) {});  // still usable
    const auto j = pool.submit([] { throw std::runtime_error("job"); });
    EXPECT_THROW(j->wait(), std::runtime_error);
  }
  EXPECT_THROW(WorkersPool(0), std::invalid_argument);
}

TEST(WorkersPool, OneAloneAtATimeAmongAllPools) {
  std::atomic<int> inside{0}, most{0};
  const auto many = [&] {
    WorkersPool pool(1);
    for (int i = 0; i < 50; ++i)
      pool.alone([&] {
        most = std::max(most.load(), ++inside);
        std::this_thread::yield();
        --inside;
      });
  };
  std::thread beside(many);
  many();
  beside.join();
  EXPECT_EQ(most.load(), 1);
  WorkersPool pool(1);  // what is thrown gets out and leaves the way free
  EXPECT_THROW(pool.alone([] { throw std::runtime_error("alone"); }), std::runtime_error);
  bool ran = false;
  pool.alone([&] { ran = true; });
  EXPECT_TRUE(ran);
}

/// METIS draws from the process's rand(): of two patients made at once each has the order that it has alone.
TEST(WorkersPool, TheOrderOfEliminationIsTheSameBesideAnother) {
  BoxSpec box;
  box.cells = {14, 13, 4}, box.size_mm = {60, 60, 10};
  const fem::ScalarMatrix A = fem::assemble_scalar(box_model(box), {}, 0);
  WorkersPool first(1), second(1);
  const std::vector<int32_t> order = fem::nested_dissection(A, first);
  std::atomic<int> differ{0};
  const auto many = [&](Workers& workers) {
    for (int i = 0; i < 200; ++i) differ += fem::nested_dissection(A, workers) != order;  // 192 without alone()
  };
  std::thread beside([&] { many(second); });
  many(first);
  beside.join();
  EXPECT_EQ(differ.load(), 0);
}

TEST(Thread, NeverInheritsRealTimeScheduling) {
  int child = -1, creator = -1;
  ScheduledThread outer([&] {
    request_real_time(5);  // may be refused: then there is nothing to inherit
    sched_param p;
    pthread_getschedparam(pthread_self(), &creator, &p);
    ScheduledThread inner([&] {
      sched_param q;
      pthread_getschedparam(pthread_self(), &child, &q);
    });
  });
  outer.join();
  EXPECT_EQ(child, SCHED_OTHER);
  RecordProperty("creator_policy", creator);
}

}  // namespace test_workers_pool
}  // namespace limberg
