#include "runtime/base/process/deep_stack.h"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>
#include <system_error>

#include "runtime/base/error.h"
#include "runtime/base/temporary_files.h"

// LLVM gives the thread that calls it a stack for signals. AddressSanitizer takes that one for its own when the thread ends, and fails to
// return it to the system; unless it leaves such stacks alone.
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define MELD_ADDRESS_SANITIZER
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define MELD_ADDRESS_SANITIZER
#endif
#ifdef MELD_ADDRESS_SANITIZER
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "use_sigaltstack=0"; }
#endif

namespace meld {

namespace {

constexpr std::size_t kMaxStack_bytes = std::size_t{512} << 20;
// Enough for every depth that the parser accepts; Clang needs more for bodies that nest hundreds of blocks.
constexpr std::size_t kMinStack_bytes = std::size_t{16} << 20;
// The stack is a share of the allowed address space: the program's data needs more than its recursion.
constexpr std::size_t kShareOfAddressSpace = 16;

std::size_t stack_bytes() {
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kMaxStack_bytes;
    return std::clamp(static_cast<std::size_t>(limit.rlim_cur) / kShareOfAddressSpace, kMinStack_bytes, kMaxStack_bytes);
}

// Written when there may be no memory left: made before.
char last_words[256] = "out of memory\n";

struct Call {
    const std::function<int()>* program;
    int result = 0;
};

void* run(void* argument) {
    Call& call = *static_cast<Call*>(argument);
    call.result = ending_when_memory_runs_out(*call.program);
    return nullptr;
}

}  // namespace

// No memory may be needed here, and other threads may be anywhere: nothing is cleaned up.
void memory_has_run_out() {
    Leftover::remove_all();
    const ssize_t unused = ::write(STDERR_FILENO, last_words, std::strlen(last_words));
    static_cast<void>(unused);
    _exit(static_cast<int>(ExitCode::LimitHit));
}

void end_when_memory_runs_out(const std::string& name) {
    const std::string text =
        name + ": out of memory, or of threads: more is needed than this process may have. Raise the limit (ulimit -v)\n";
    std::strncpy(last_words, text.c_str(), sizeof last_words - 1);
    std::set_new_handler(memory_has_run_out);
}

int ending_when_memory_runs_out(const std::function<int()>& program) {
    try {
        return program();
    } catch (const std::bad_alloc&) {
        memory_has_run_out();
    } catch (const std::length_error&) {
        memory_has_run_out();
    } catch (const std::system_error&) {
        memory_has_run_out();
    }
}

int with_deep_stack(const std::string& name, const std::function<int()>& program) {
    end_when_memory_runs_out(name);
    Call call{&program};
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    for (std::size_t bytes = stack_bytes(); bytes >= kMinStack_bytes; bytes /= 2) {
        pthread_attr_setstacksize(&attributes, bytes);
        pthread_t thread{};
        if (pthread_setattr_default_np(&attributes) != 0 || pthread_create(&thread, &attributes, run, &call) != 0) continue;
        pthread_join(thread, nullptr);
        pthread_attr_destroy(&attributes);
        return call.result;
    }
    memory_has_run_out();
}

}  // namespace meld
