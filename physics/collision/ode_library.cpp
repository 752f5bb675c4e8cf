// ODE's global state and its handlers. The library is never closed: worlds in other threads may still use it.
#include "physics/collision/ode_library.h"

#include <ode/ode.h>

#include <cstdarg>
#include <cstdio>
#include <mutex>

namespace meld::physics {

namespace {

std::string text_of(const char* message, va_list values) {
    char text[512];
    std::vsnprintf(text, sizeof text, message, values);
    return text;
}

// dError and dDebug end the process if a handler returns.
[[noreturn]] void fatal(int, const char* message, va_list values) { throw OdeFailure(text_of(message, values)); }

// Warnings are about input that is checked here before ODE sees it.
void remark(int, const char*, va_list) {}

}  // namespace

void start_ode() {
    static std::once_flag started;
    std::call_once(started, [] {
        dInitODE2(0);
        dSetErrorHandler(fatal);
        dSetDebugHandler(fatal);
        dSetMessageHandler(remark);
    });
}

void enter_ode_thread() {
    start_ode();
    thread_local const int allocated = dAllocateODEDataForThread(static_cast<unsigned>(dAllocateMaskAll));
    static_cast<void>(allocated);
}

}  // namespace meld::physics
