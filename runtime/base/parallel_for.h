// The only way this project starts threads.
#pragma once

#include <cstddef>
#include <functional>

namespace meld {

// A fixed set of worker threads. run(n, f) calls f(worker, index) for index 0..n-1, each exactly once, on any worker;
// it returns when all are done. With one thread everything happens in the calling thread, in order.
class Workers {
  public:
    explicit Workers(int threads);
    ~Workers();
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;
    int threads() const { return threads_; }
    void run(std::size_t count, const std::function<void(int worker, std::size_t index)>& body);

  private:
    struct Shared;
    int threads_;
    Shared* shared_;
};

}  // namespace meld
