// Opens a link in the browser of whoever sits at this machine.
#pragma once

#include <string>

#include "runtime/base/temporary_files.h"

namespace meld::driver {

// A file that only this user can read leads the browser to the link, since everybody on the machine can read what commands are given.
// It goes with this object. What cannot be opened is not opened: the link has been printed.
class OpenedLink {
  public:
    explicit OpenedLink(const std::string& link);
    ~OpenedLink();
    OpenedLink(const OpenedLink&) = delete;
    OpenedLink& operator=(const OpenedLink&) = delete;

    // Whether there is a screen.
    static bool can_open();

  private:
    std::string path_;
    Leftover leftover_;
};

}  // namespace meld::driver
