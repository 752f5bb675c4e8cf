// A body that is watched during a run, beside the same body asked after every tick.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>

#include "runtime/ask/facts/program.h"
#include "runtime/ask/watch/watches.h"

namespace meld::reference {

class Watched {
  public:
    // Every process makes it. `asks`: the body is asked too, on the only process. Nothing happens if the run cannot answer it.
    Watched(const ModuleInfo& module, const std::string& body, bool asks);
    ~Watched();
    Watched(const Watched&) = delete;
    Watched& operator=(const Watched&) = delete;

    // After a tick that went well. Returns the trouble.
    std::string after(sim::Subdomain& subdomain);
    // The lines that the watch has told so far: on process 0.
    std::string told();
    std::uint64_t lines() const { return lines_; }

  private:
    // Nothing if there are too many.
    std::optional<std::set<std::string>> ways(sim::Subdomain& subdomain) const;

    std::string body_;
    bool asks_;
    char* text_ = nullptr;
    std::size_t size_ = 0, seen_ = 0;
    std::FILE* out_ = nullptr;
    std::unique_ptr<inspect::Watches> watches_;
    std::optional<inspect::Program> program_;
    std::set<std::string> before_;
    std::uint64_t lines_ = 0;
};

}  // namespace meld::reference
