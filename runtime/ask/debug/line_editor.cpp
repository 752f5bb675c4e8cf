#include "runtime/ask/debug/line_editor.h"

#include <fmt/format.h>
#include <histedit.h>
#include <locale.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <cwchar>
#include <utility>

#include "runtime/ask/debug/line_history.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld::debug {

namespace {

constexpr int kMostHistory = 1000;
// So many words are listed.
constexpr std::size_t kMostWords = 100;

// ---- the mode of the terminal, for handlers of signals

termios as_it_was{};
std::atomic<bool> editing{false};
std::atomic<bool> resized{false}, continued{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void restore_terminal() {
    if (editing.load()) ::tcsetattr(STDIN_FILENO, TCSANOW, &as_it_was);
}

void on_change(int signal) { (signal == SIGWINCH ? resized : continued).store(true); }

// The shell gets its terminal as it was. Where none has started this process, the system passes over the stop.
void on_stop(int signal) {
    const int before_errno = errno;
    restore_terminal();
    struct sigaction action{}, before{};
    action.sa_handler = SIG_DFL;
    ::sigaction(signal, &action, &before);
    sigset_t this_one;
    sigemptyset(&this_one);
    sigaddset(&this_one, signal);
    ::raise(signal);
    // Here it stops, until it goes on.
    ::pthread_sigmask(SIG_UNBLOCK, &this_one, nullptr);
    ::sigaction(signal, &before, nullptr);
    continued.store(true);
    errno = before_errno;
}

// What was done before the first one is done now.
void on_end(int signal) {
    restore_terminal();
    ::raise(signal);
}

// While a line is read.
class Editing {
  public:
    Editing() {
        if (::tcgetattr(STDIN_FILENO, &as_it_was) != 0) return;
        editing.store(true);
        interrupt::set_last_step(restore_terminal);
        set(SIGWINCH, on_change, 0);
        set(SIGCONT, on_change, 0);
        set(SIGTSTP, on_stop, 0);
        for (const int signal : {SIGQUIT, SIGABRT, SIGSEGV, SIGBUS, SIGILL, SIGFPE})
            set(signal, on_end, static_cast<int>(SA_RESETHAND | SA_NODEFER));
    }
    ~Editing() {
        for (std::size_t i = 0; i < count_; ++i) ::sigaction(before_[i].first, &before_[i].second, nullptr);
        interrupt::set_last_step(nullptr);
        restore_terminal();
        editing.store(false);
    }
    Editing(const Editing&) = delete;
    Editing& operator=(const Editing&) = delete;

  private:
    void set(int signal, void (*handler)(int), int flags) {
        if (interrupt::is_ignored(signal)) return;
        struct sigaction action{};
        action.sa_handler = handler;
        action.sa_flags = flags;
        auto& [number, before] = before_[count_];
        number = signal;
        if (::sigaction(signal, &action, &before) == 0) ++count_;
    }
    std::array<std::pair<int, struct sigaction>, 9> before_{};
    std::size_t count_ = 0;
};

// The editor counts characters as the locale says; the rest of the program knows no locale.
class Utf8 {
  public:
    explicit Utf8(locale_t locale) : before_(::uselocale(locale)) {}
    ~Utf8() { ::uselocale(before_); }
    Utf8(const Utf8&) = delete;
    Utf8& operator=(const Utf8&) = delete;

  private:
    locale_t before_;
};

// ---- completion

std::string common_start(const std::vector<std::string>& words) {
    std::string common = words.front();
    for (const std::string& word : words) common.resize(static_cast<std::size_t>(std::ranges::mismatch(common, word).in1 - common.begin()));
    return common;
}

// In columns, from top to bottom.
std::string listed(const std::vector<std::string>& words, std::size_t width) {
    const std::size_t count = std::min(words.size(), kMostWords);
    std::size_t longest = 1;
    for (std::size_t i = 0; i < count; ++i) longest = std::max(longest, words[i].size());
    const std::size_t columns = std::max<std::size_t>(1, width / (longest + 2)), rows = (count + columns - 1) / columns;
    std::string out;
    for (std::size_t row = 0; row < rows; ++row) {
        for (std::size_t at = row; at < count; at += rows)
            out += at + rows < count ? fmt::format("{:<{}}", visible(words[at]), longest + 2) : visible(words[at]);
        out += "\n";
    }
    return words.size() > count ? out + "and more\n" : out;
}

}  // namespace

// What libedit calls back to.
struct LineEditor::Terminal {
    explicit Terminal(std::string history_file) : file(std::move(history_file)) {}
    ~Terminal() {
        if (edit != nullptr) ::el_end(edit);
        if (history != nullptr) ::history_end(history);
        if (utf8 != nullptr) ::freelocale(utf8);
    }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;

    bool begin();
    void remember(const std::string& line);
    int next(wchar_t* out);
    unsigned char complete_word();

    static Terminal& of(EditLine* edit) {
        void* self = nullptr;
        ::el_get(edit, EL_CLIENTDATA, &self);
        return *static_cast<Terminal*>(self);
    }

    LineHistory file;
    EditLine* edit = nullptr;
    ::History* history = nullptr;
    locale_t utf8 = nullptr;
    std::string prompt;
    Complete complete;
    std::string last_line;
    // Why there is no further character.
    enum class Ended { No, Signal, Input } ended = Ended::No;
    int error = 0;             // An errno.
    bool typed_ahead = false;  // What comes had been typed before the prompt was there.
};

bool LineEditor::Terminal::begin() {
    utf8 = ::newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);
    if (utf8 == nullptr) return false;
    const Utf8 here(utf8);
    edit = ::el_init("meldsim", stdin, stdout, stderr);
    history = ::history_init();
    if (edit == nullptr || history == nullptr) return false;
    HistEvent event{};
    ::history(history, &event, H_SETSIZE, kMostHistory);
    ::history(history, &event, H_SETUNIQUE, 1);
    for (const std::string& line : file.load()) {
        ::history(history, &event, H_ENTER, line.c_str());
        last_line = line;
    }
    ::el_set(edit, EL_CLIENTDATA, this);
    ::el_set(edit, EL_SIGNAL, 0);
    ::el_set(edit, EL_EDITOR, "emacs");
    ::el_set(edit, EL_PROMPT, +[](EditLine* of_line) { return of(of_line).prompt.data(); });
    ::el_set(edit, EL_GETCFN, +[](EditLine* of_line, wchar_t* out) { return of(of_line).next(out); });
    ::el_set(edit, EL_HIST, ::history, history);
    ::el_set(
        edit, EL_ADDFN, "meld-complete", "Complete the word before the cursor",
        +[](EditLine* of_line, int) { return of(of_line).complete_word(); });
    constexpr std::array<std::pair<const char*, const char*>, 11> kKeys = {{{"^I", "meld-complete"},
                                                                            {"^R", "em-inc-search-prev"},
                                                                            {"\\e[3~", "ed-delete-next-char"},
                                                                            {"\\e[1~", "ed-move-to-beg"},
                                                                            {"\\e[4~", "ed-move-to-end"},
                                                                            {"\\e[H", "ed-move-to-beg"},
                                                                            {"\\e[F", "ed-move-to-end"},
                                                                            {"\\e[1;5C", "em-next-word"},
                                                                            {"\\e[1;5D", "ed-prev-word"},
                                                                            {"\\eOC", "ed-next-char"},
                                                                            {"\\eOD", "ed-prev-char"}}};
    for (const auto& [keys, does] : kKeys) ::el_set(edit, EL_BIND, keys, does, nullptr);
    // As other programs with this editor read it: ~/.editrc.
    ::el_source(edit, nullptr);
    return true;
}

void LineEditor::Terminal::remember(const std::string& line) {
    if (line.find_first_not_of(" \t") == std::string::npos) return;
    HistEvent event{};
    ::history(history, &event, H_ENTER, line.c_str());
    if (line != last_line) file.add(line);
    last_line = line;
}

// The next character of the terminal. 1: there is one; otherwise -1.
int LineEditor::Terminal::next(wchar_t* out) {
    std::mbstate_t state{};
    while (true) {
        if (interrupt::received() != 0) {
            ended = Ended::Signal;
            return -1;
        }
        const bool again = continued.exchange(false);
        if (again) {
            ::el_set(edit, EL_PREP_TERM, 0);
            ::el_set(edit, EL_PREP_TERM, 1);
        }
        if (resized.exchange(false)) ::el_resize(edit);
        if (again) ::el_set(edit, EL_REFRESH);
        pollfd in = {.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        const int ready = ::poll(&in, 1, typed_ahead ? 0 : kPoll_ms);
        if (ready == 0) typed_ahead = false;
        if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
        char byte = 0;
        const ssize_t size = ::read(STDIN_FILENO, &byte, 1);
        if (size < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        if (size <= 0) {
            ended = Ended::Input;
            // Where it has gone away, that is the end of what somebody says.
            error = size < 0 && errno != EIO ? errno : 0;
            return -1;
        }
        if (byte == '\0') {
            // So the terminal keeps a Ctrl-D that came before the prompt. Any other would end the line for the editor, and not for whoever
            // typed it.
            const LineInfo* const line = ::el_line(edit);
            if (!typed_ahead || line->lastchar != line->buffer) continue;
            ended = Ended::Input;
            return -1;
        }
        const std::size_t length = std::mbrtowc(out, &byte, 1, &state);
        if (length == 1) return 1;
        // No character at all.
        if (length == static_cast<std::size_t>(-1)) state = {};
    }
}

unsigned char LineEditor::Terminal::complete_word() {
    const LineInfo* const line = ::el_line(edit);
    const std::string_view typed(line->buffer, static_cast<std::size_t>(line->cursor - line->buffer));
    const Completion found = complete ? complete(typed) : Completion{};
    if (found.words.empty()) return CC_ERROR;
    const std::string_view word = typed.substr(std::min(found.begin, typed.size()));
    std::string more = common_start(found.words).substr(word.size());
    if (found.words.size() == 1 && line->cursor == line->lastchar) more += found.after;
    if (!more.empty()) return ::el_insertstr(edit, more.c_str()) == 0 ? CC_REFRESH : CC_ERROR;
    if (found.words.size() == 1) return CC_ERROR;
    winsize size{};
    const bool known = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    std::fputs(("\n" + listed(found.words, known ? size.ws_col : 80U)).c_str(), stdout);
    return CC_REDISPLAY;
}

std::unique_ptr<LineEditor> LineEditor::open(const std::string& history) {
    const char* const kind = std::getenv("TERM");
    if (kind == nullptr || *kind == '\0' || std::strcmp(kind, "dumb") == 0) return nullptr;
    if (::isatty(STDIN_FILENO) == 0 || ::isatty(STDOUT_FILENO) == 0) return nullptr;
    auto terminal = std::make_unique<Terminal>(history);
    if (!terminal->begin()) return nullptr;
    return std::unique_ptr<LineEditor>(new LineEditor(std::move(terminal)));
}

LineEditor::LineEditor(std::unique_ptr<Terminal> terminal) : terminal_(std::move(terminal)) {}

LineEditor::~LineEditor() = default;

void LineEditor::complete_by(Complete complete) { terminal_->complete = std::move(complete); }

Result<LineEditor::Typed> LineEditor::read(const std::string& prompt) {
    Terminal& t = *terminal_;
    t.prompt = prompt;
    t.ended = Terminal::Ended::No;
    t.error = 0;
    t.typed_ahead = true;
    const Utf8 here(t.utf8);
    const Editing now;
    // It may have changed while no line was read.
    ::el_resize(t.edit);
    int length = 0;
    const char* const text = ::el_gets(t.edit, &length);
    if (text == nullptr || length <= 0) {
        if (t.error != 0) return fail(fmt::format("cannot read standard input: {}", std::strerror(t.error)));
        const bool signal = t.ended == Terminal::Ended::Signal;
        return Typed{signal ? Typed::What::Interrupted : Typed::What::End};
    }
    std::string line(text);
    while (line.ends_with('\n') || line.ends_with('\r')) line.pop_back();
    t.remember(line);
    return Typed{Typed::What::Line, std::move(line)};
}

}  // namespace meld::debug
