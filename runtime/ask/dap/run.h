// The run that is walked through, as the adapter asks it: a session of the debugger in another process.
#pragma once

#include <string>

#include "runtime/ask/dap/launch.h"
#include "runtime/base/error.h"

namespace meld::dap {

class Run {
  public:
    virtual ~Run() = default;

    // Starts the run of a launch. Errors: it cannot be started.
    virtual Result<void> start(const Launch& launch) = 0;
    // Carries out one command of the debugger, a single line; its answer has the text for people as `text`. Errors: of the command; or the
    // run has ended, which alive() says. It takes as long as the command takes, and meanwhile the client is listened to.
    virtual Result<Json> ask(const std::string& command) = 0;
    // What is being done is to end soon. Without effect if nothing is.
    virtual void pause() = 0;
    virtual bool alive() const = 0;
    // Ends it, if it has not ended. Returns its exit code.
    virtual int end() = 0;
};

}  // namespace meld::dap
