// The hand-written modules of a run, at each catom of a process.
#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class CodeModules {
  public:
    Result<void> add(const Registry::MakeCode& make, const world::World& world);
    // The per-catom side of a component, which its owner keeps.
    void add(CodeModule& shared) { modules_.push_back({&shared, nullptr, {}, {}}); }
    // Lets every module find the predicates it uses, once, before the first run.
    Result<void> look_up(const ModuleInfo& module);
    // Runs every module at every catom of this process, catoms in the order of their indices. Cost: all catoms, in every tick, because such
    // code does not know what has changed.
    void run(Subdomain& subdomain);
    // After the ensemble was divided anew: objects go where their catoms are. Every process calls it.
    void follow(Subdomain& subdomain);
    // A catom begins anew: so does its object.
    void forget(std::uint64_t id) {
        for (Entry& entry : modules_) entry.own.erase(id);
    }
    // The state of all modules, for a snapshot, and back: of the objects whose catoms this process owns now, and of those that are
    // shared as `shared` says, which is so for one of the processes that wrote it.
    void save(ByteWriter& out) const;
    void load(Subdomain& subdomain, bool shared, ByteReader& in);
    bool empty() const { return modules_.empty(); }

  private:
    struct Entry {
        CodeModule* shared = nullptr;
        std::unique_ptr<CodeModule> owned;  // The same, unless it is a component.
        Registry::MakeCode make;
        std::unordered_map<std::uint64_t, std::unique_ptr<CodeModule>> own;  // By id
    };
    // A new object for one catom.
    std::unique_ptr<CodeModule> instance_of(const Entry& entry, const ModuleInfo& module) const;
    // Instances migrate with their catoms.
    void follow(Subdomain& subdomain, Entry& entry);
    void load_own(Subdomain& subdomain, Entry& entry, ByteReader& in) const;

    std::vector<Entry> modules_;
    const world::World* world_ = nullptr;
};

}  // namespace meld::sim
