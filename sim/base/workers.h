#pragma once
// Where `sim` gets its parallelism from. `sim` starts no thread; whoever owns a World hands it a Workers object.
//
// Results never depend on the number of workers: parallel_for splits [0,n) into the same chunks whatever the count,
// and a caller that reduces does so over chunks in order.
#include <cstddef>
#include <functional>
#include <memory>

namespace limberg {

class Workers {
 public:
  /// A background job. The job may not touch anything its submitter still writes.
  class Job {
   public:
    virtual ~Job() = default;
    virtual bool done() const = 0;  // true once the job's writes are visible to the caller
    virtual void wait() = 0;        // returns when done; runs the job here and now if nobody has begun it
  };

  virtual ~Workers() = default;
  virtual int count() const = 0;  // >= 1, the caller included
  /// Calls body(begin, end) over chunks of [0,n) of at most `grain`; returns when all are done.
  virtual void parallel_for(size_t n, size_t grain, const std::function<void(size_t, size_t)>& body) = 0;
  virtual std::shared_ptr<Job> submit(std::function<void()> job) = 0;
  /// Runs `job` here and now, while no other thread of the process is in an alone(): for a library that keeps something
  /// which the whole process shares (METIS draws from the C library's rand()). Whoever works on several Worlds at once
  /// overrides it by one lock for all; this one is for a process with a single World at work.
  virtual void alone(const std::function<void()>& job) { job(); }
};

/// Everything on the calling thread; a submitted job runs when it is waited for (done() is false until then).
class InlineWorkers final : public Workers {
 public:
  int count() const override { return 1; }
  void parallel_for(size_t n, size_t grain, const std::function<void(size_t, size_t)>& body) override {
    for (size_t b = 0; b < n; b += grain) body(b, b + grain < n ? b + grain : n);
  }
  std::shared_ptr<Job> submit(std::function<void()> job) override {
    struct Lazy final : Job {
      std::function<void()> f;
      bool finished = false;
      bool done() const override { return finished; }
      void wait() override {
        if (!finished) f(), finished = true;
      }
    };
    auto j = std::make_shared<Lazy>();
    j->f = std::move(job);
    return j;
  }
};

}  // namespace limberg
