// How a run is asked to end: Ctrl-C, and the signals of those who started it. What the first one does depends on what the process is
// doing; the second one always ends it at once. An end at once is the system's: no destructor runs, so it is for times at which
// nothing is half written.
#pragma once

#include <initializer_list>

namespace meld::interrupt {

enum class Answer {
    // The process ends at once: while it sets up.
    AtOnce,
    // It is asked to end, by received(), and ended if it has not after kPatience_s: while it makes ticks.
    Soon,
    // It is asked to end, and takes its time: while it writes results.
    Patiently,
};

// The commands promise an end within two seconds.
inline constexpr double kPatience_s = 1.7;
// After which a step that is still at work should give up, so that there is time for an orderly end.
inline constexpr double kStep_s = 0.7;

// From now on these signals are answered, AtOnce at first; not those that the process was started to ignore, as `nohup` asks for.
// Call it once, from the main thread, before there are others.
void handle(std::initializer_list<int> signals);

// Written to standard error when the process is ended; a text that lives for ever, or nullptr for silence, which is so at first.
void set_last_words(const char* words);

// The signal that came first; 0 if none has.
int received();
// 130 after SIGINT, 143 after SIGTERM, as shells count; other signals count as SIGINT.
int exit_code();
// The first signal is answered Soon and has waited for kStep_s. Any thread may ask; cheap.
bool overdue();

// Answers otherwise as long as it lives. One thread makes them, one within the other.
class Answering {
  public:
    explicit Answering(Answer answer);
    ~Answering();
    Answering(const Answering&) = delete;
    Answering& operator=(const Answering&) = delete;

  private:
    Answer before_;
};

}  // namespace meld::interrupt
