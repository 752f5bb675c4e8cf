#include "runtime/ask/dap/serve.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "runtime/ask/dap/adapter.h"
#include "runtime/ask/dap/child.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld::dap {

namespace {

// Of what the run has said of its end.
constexpr std::size_t kMaxLastWords_bytes = 4096;
constexpr int kLastWords_ms = 200;

class Conversation : public Run {
  public:
    Conversation()
        : client_([this](const std::string& message) {
              if (!print(stdout, message)) gone_ = true;
          }),
          adapter_(*this, client_) {}

    int hold() {
        while (!adapter_.over() && !wrong_ && (!gone_ || !waiting_.empty())) {
            if (!waiting_.empty()) {
                const Request request = std::move(waiting_.front());
                waiting_.pop_front();
                adapter_.take(request);
            } else if (adapter_.has_work()) {
                adapter_.work([this] { return !waiting_.empty() || gone_; });
            } else {
                listen();
                if (child_ && child_->output() < 0) adapter_.ended();
            }
        }
        end();
        if (wrong_) static_cast<void>(print(stderr, fmt::format("meldsim: {}\n", visible(wrong_->message()))));
        return wrong_ ? static_cast<int>(wrong_->code) : adapter_.over() ? 0 : 1;
    }

    // ---- the run

    Result<void> start(const Launch& launch) override {
        Result<Child> child = Child::start(launch.words, launch.folder);
        if (!child) return tl::unexpected<Error>(child.error());
        child_.emplace(std::move(*child));
        return {};
    }

    Result<Json> ask(const std::string& command) override {
        asking_ = true;
        paused_ = false;
        if (alive()) child_->write(command + "\n");
        std::optional<std::string> line;
        while (alive() && !(line = answer())) {
            // Somebody waits, and the run can go on later.
            if (adapter_.moving() && (!waiting_.empty() || gone_ || wrong_)) pause();
            listen();
        }
        asking_ = false;
        if (!line) return fail(last_words());
        const Json json = Json::parse(*line, nullptr, false);
        if (!json.is_object()) return fail("the run has said something else than an answer: " + visible(*line), "", ExitCode::OurBug);
        if (!json.contains("error")) return json;
        return fail(json["error"].get<std::string>(), json.value("suggestion", ""), static_cast<ExitCode>(json.value("code", 2)));
    }

    // The word is read between two ticks, or when the next command is; it ends what was begun before it, and nothing else.
    void pause() override {
        if (asking_ && alive() && !std::exchange(paused_, true)) child_->write("pause\n");
    }

    bool alive() const override { return child_ && child_->output() >= 0; }

    int end() override {
        if (child_) exit_code_ = child_->end();
        return exit_code_;
    }

  private:
    // The next line of the run that is not empty.
    std::optional<std::string> answer() {
        while (true) {
            const std::size_t end = lines_.find('\n');
            if (end == std::string::npos) return std::nullopt;
            std::string line = lines_.substr(0, end);
            lines_.erase(0, end + 1);
            if (!line.empty()) return line;
        }
    }

    // Waits until somebody says something, and takes it.
    void listen() {
        std::array<pollfd, 3> ends = {pollfd{gone_ ? -1 : STDIN_FILENO, POLLIN, 0}, pollfd{child_ ? child_->output() : -1, POLLIN, 0},
                                      pollfd{child_ ? child_->errors() : -1, POLLIN, 0}};
        if (::poll(ends.data(), ends.size(), -1) <= 0) return;
        // What the run says of its end comes before the end.
        if (ends[2].revents != 0) hear_errors();
        if (ends[1].revents != 0) lines_ += child_->read_output();
        if (child_ && child_->output() < 0) hear_last_errors();
        if (ends[0].revents != 0) hear_client();
    }

    void hear_errors() {
        const std::string text = child_->read_errors();
        if (text.empty()) return;
        client_.output("stderr", visible(text));
        last_words_ += text;
        if (last_words_.size() > kMaxLastWords_bytes) last_words_.erase(0, last_words_.size() - kMaxLastWords_bytes);
    }

    // What it has still said; somebody else may hold the pipe, so its end is not waited for.
    void hear_last_errors() {
        for (pollfd end = {child_->errors(), POLLIN, 0}; end.fd >= 0 && ::poll(&end, 1, kLastWords_ms) > 0; end.fd = child_->errors())
            hear_errors();
    }

    void hear_client() {
        std::string block(1 << 16, '\0');
        const ssize_t size = ::read(STDIN_FILENO, block.data(), block.size());
        if (size < 0 && errno == EINTR) return;
        if (size <= 0) {
            gone_ = true;
            // Nobody is left who wants it.
            if (asking_) end();
            return;
        }
        reader_.add(std::string_view(block).substr(0, static_cast<std::size_t>(size)));
        while (!wrong_) {
            Result<std::optional<std::string>> text = reader_.next();
            if (!text) {
                wrong_ = text.error();
                return;
            }
            if (!*text) return;
            const Result<Request> request = parse_request(**text);
            // Whoever has sent it cannot be answered.
            if (!request)
                client_.output("stderr", fmt::format("meldsim: {}\n", request.error().message()));
            else if (!asking_ || !adapter_.take_meanwhile(*request))
                waiting_.push_back(*request);
        }
    }

    // The first line is what went wrong; what follows explains it.
    std::string last_words() const {
        const std::string line = last_words_.substr(0, last_words_.find('\n'));
        return line.empty() ? "the run has ended" : visible(line);
    }

    Writer client_;
    Adapter adapter_;
    Reader reader_;
    std::deque<Request> waiting_;
    std::optional<Child> child_;
    std::string lines_, last_words_;  // Of the run, as far as they were not looked at; and what it has said on standard error.
    std::optional<Error> wrong_;
    int exit_code_ = 0;
    bool asking_ = false, paused_ = false, gone_ = false;
};

}  // namespace

int serve() { return Conversation().hold(); }

}  // namespace meld::dap
