// How a run is asked to end: Ctrl-C, and the signals of those who started it. What the first one does depends on what the process is
// doing; the second one always ends it at once. An end at once is the system's: no destructor runs, so it is for times at which
// nothing is half written; files that are no results yet go (runtime/base/temporary_files.h).
#pragma once

#include <initializer_list>
#include <string_view>

namespace meld::interrupt {

enum class Answer {
    // The process ends at once: while it sets up.
    AtOnce,
    // received() reports the request, and the process is ended if it has not ended after kPatience_s: while it makes ticks.
    Soon,
    // received() reports the request, without a time limit: while it writes results.
    Patiently,
};

// The commands promise an end within two seconds.
inline constexpr double kPatience_s = 1.7;
// After this time a step that is still running should give up, so that there is time for an orderly end.
inline constexpr double kStep_s = 0.7;

// Whether the process was started to ignore it, as `nohup` and similar commands ask for. Also for use between fork and exec.
bool is_ignored(int signal);

// From now on these signals are answered, AtOnce at first; not those that are ignored. `repeated` are those that their sender may repeat or
// send by two ways: none is ever the second. Those that were blocked until now come. Call it once, from the main thread, before there are
// others.
void handle(std::initializer_list<int> signals, std::initializer_list<int> repeated = {});

// From now on these signals wait until they are handled: for those who make what must not be left before that. From the main thread.
void hold(std::initializer_list<int> signals);

// From now on an end at once is by the signal itself, not by an exit code: a shell then ends the loop in which the command stands.
void end_by_signal();

// Written to standard error when the process is ended; a string that is never freed, or nullptr (the default) for silence. The supervisor
// learns from the table of runtime/base/process/liveness.h that they have been written, or that nullptr has been set: all has been said.
void set_last_words(const char* words);

// What is done then, too, before the words: a function that may be called in handlers of signals; nullptr (the default) for nothing.
void set_last_step(void (*step)());

// The signal that came first; 0 if none has.
int received();
// Takes back a request to stop what is being done, such as Ctrl-C: the next one is the first again. False, and nothing is done, if it was
// one to end the process: SIGTERM, SIGHUP, or the time is up. Not while the answer is Soon.
bool forget_request();
// 130 after SIGINT, 143 after SIGTERM, as shells count; other signals count as SIGINT. 4 when the time is up.
int exit_code();
// Whether the first signal is to be answered Soon and has waited for kStep_s. Any thread may ask; cheap.
bool overdue();

// The process may take so many seconds, by the clock on the wall, from now to the end of this object. Then it is as if a signal had come,
// but the exit code is that of a limit, and the last words, which begin with `name`, say why. One at a time, and after handle().
class TimeLimit {
  public:
    TimeLimit(std::string_view name, double seconds);
    ~TimeLimit();
    TimeLimit(const TimeLimit&) = delete;
    TimeLimit& operator=(const TimeLimit&) = delete;
};
// What came first is the end of the time.
bool time_is_up();

// Changes the answer during its lifetime. Made by one thread, nested.
class Answering {
  public:
    explicit Answering(Answer answer);
    ~Answering();
    Answering(const Answering&) = delete;
    Answering& operator=(const Answering&) = delete;

  private:
    Answer before_;
};

// While it lives, a signal waits: for a few steps of which none may be the last. A signal that would have ended the process does so
// after them. On the thread of Answering, and one within the other with these.
class Undivided {
  public:
    Undivided();
    ~Undivided();
    Undivided(const Undivided&) = delete;
    Undivided& operator=(const Undivided&) = delete;

  private:
    bool had_received_;
    Answer before_;
};

}  // namespace meld::interrupt
