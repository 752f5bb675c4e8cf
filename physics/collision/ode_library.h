// Use of ODE: it is initialized once, its fatal errors become exceptions that are caught where it was called, and every thread that
// collides gets its memory.
#pragma once

#include <stdexcept>
#include <string>

namespace meld::physics {

// Thrown out of ODE's error handlers, which must not return; only physics code that calls ODE sees it.
struct OdeFailure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Initializes ODE and installs the error handlers; cheap after the first time. Any thread.
void start_ode();
// A thread must call this before dCollide; cheap after the first time.
void enter_ode_thread();

}  // namespace meld::physics
