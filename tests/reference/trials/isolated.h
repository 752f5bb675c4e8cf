// Runs something in a child process, so that an assertion, a crash or an endless loop of the compiler or the runtime is one
// more answer, and can be made small like any other.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>

namespace meld::reference {

// A child process at work on something.
class Child {
  public:
    // 0: it may take as long as it likes. No threads may run here meanwhile.
    explicit Child(const std::function<std::string()>& body, unsigned limit_seconds);
    // What body() returned in the child; or "crash: ..." with what the child has said last, where it ended in another way or took
    // longer than the limit. Waits for it; to be called once.
    std::string answer();

  private:
    pid_t pid_ = -1;
    int out_ = -1;
    unsigned limit_seconds_;
};

// One child, and its answer. Random programs mostly take seconds; those whose rules have very many answers took up to 270 s of CPU.
inline std::string isolated(const std::function<std::string()>& body, unsigned limit_seconds = 300) {
    return Child(body, limit_seconds).answer();
}

}  // namespace meld::reference
