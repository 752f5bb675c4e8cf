// A process that was started here, with pipes to its standard streams.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"

namespace meld::dap {

class Child {
  public:
    // This program again, with these words as its command line, in this folder; an empty one is that of this process. It ends with this
    // process. Errors: it cannot be started.
    static Result<Child> start(const std::vector<std::string>& words, const std::string& folder);

    Child(Child&& other) noexcept;
    Child& operator=(Child&&) = delete;
    ~Child() { end(); }

    // What it has written to its standard output and error, from this descriptor on; -1 when it has closed it.
    int output() const { return output_; }
    int errors() const { return errors_; }
    // Reads what there is, without an end to wait for; empty: it has closed it.
    std::string read_output() { return read(output_); }
    std::string read_errors() { return read(errors_); }
    // False: it reads no more.
    bool write(std::string_view text);

    // Closes its input, by which it should end, then asks it to end, and then kills it: within some three seconds. Returns its exit code,
    // or 128 and the signal that has ended it.
    int end();

  private:
    Child() = default;
    static std::string read(int& descriptor);
    bool has_ended();
    bool ends_within(std::chrono::milliseconds time);

    pid_t process_ = -1;  // -1: it has ended.
    int input_ = -1, output_ = -1, errors_ = -1, exit_code_ = 0;
};

}  // namespace meld::dap
