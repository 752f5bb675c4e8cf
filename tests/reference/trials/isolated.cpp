#include "tests/reference/trials/isolated.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>

namespace meld::reference {

namespace {

// Begins the answer of a child that came to its end.
constexpr std::string_view kAnswer = "\x01";

[[noreturn]] void run(const std::function<std::string()>& body, unsigned limit_seconds, int out) {
    dup2(out, STDERR_FILENO);
    alarm(limit_seconds);
    const std::string answer = std::string(kAnswer) + body();
    for (std::size_t written = 0; written < answer.size();) {
        const ssize_t n = write(out, answer.data() + written, answer.size() - written);
        if (n <= 0) break;
        written += static_cast<std::size_t>(n);
    }
    _exit(0);
}

}  // namespace

Child::Child(const std::function<std::string()>& body, unsigned limit_seconds) : limit_seconds_(limit_seconds) {
    int ends[2];
    std::fflush(nullptr);
    if (pipe(ends) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
        close(ends[0]);
        run(body, limit_seconds, ends[1]);
    }
    close(ends[1]);
    out_ = ends[0];
}

std::string Child::answer() {
    if (out_ < 0) return "crash: no pipe";
    std::string text;
    char buffer[4096];
    for (ssize_t n = 0; (n = read(out_, buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
    close(out_);
    int status = 0;
    waitpid(pid_, &status, 0);
    const std::size_t answer = text.find(kAnswer);
    if (answer != std::string::npos && WIFEXITED(status) && WEXITSTATUS(status) == 0) return text.substr(answer + kAnswer.size());
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM) return fmt::format("crash: took longer than {} s\n{}", limit_seconds_, text);
    return fmt::format("crash: {} {}\n{}", WIFEXITED(status) ? "exit code" : "signal",
                       WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status), text);
}

}  // namespace meld::reference
