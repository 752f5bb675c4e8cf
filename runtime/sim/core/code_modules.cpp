#include "runtime/sim/core/code_modules.h"

#include <map>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"

namespace meld::sim {

Result<void> CodeModules::add(const Registry::MakeCode& make, const world::World& world) {
    world_ = &world;
    Result<std::unique_ptr<CodeModule>> module = make(world);
    if (!module) return tl::unexpected<Error>(module.error());
    CodeModule* shared = module->get();
    if (shared->runnable()) modules_.push_back({shared, std::move(*module), make, {}});
    return {};
}

Result<void> CodeModules::look_up(const ModuleInfo& module) {
    for (Entry& entry : modules_)
        if (Result<void> found = entry.shared->look_up(Names(module)); !found) return found;
    return {};
}

std::unique_ptr<CodeModule> CodeModules::instance_of(const Entry& entry, const ModuleInfo& module) const {
    std::unique_ptr<CodeModule> instance = std::move(*entry.make(*world_));
    const Result<void> found = instance->look_up(Names(module));
    MELD_CHECK(found.has_value(), "a module finds other names than at the start: {}", found.error().message());
    return instance;
}

void CodeModules::run(Subdomain& subdomain) {
    for (Entry& entry : modules_) {
        const bool own = entry.shared->instances() == CodeModule::Instances::PerCatom;
        if (own && !subdomain.alone() && subdomain.world.motion.kind != "none") follow(subdomain, entry);
        for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
            if (!subdomain.owned(c) || subdomain.is_silent(c)) continue;
            CatomView view(subdomain, c);
            if (!own) {
                entry.shared->run(view);
                continue;
            }
            std::unique_ptr<CodeModule>& instance = entry.own[subdomain.ensemble.id(c)];
            if (instance == nullptr) instance = instance_of(entry, subdomain.module);
            instance->run(view);
        }
    }
}

void CodeModules::save(ByteWriter& out) const {
    for (const Entry& entry : modules_) {
        ByteWriter shared, own;
        entry.shared->save(shared);
        out.write_block(shared.view());
        // In the order of the ids, so that a snapshot is the same each time.
        std::map<std::uint64_t, const CodeModule*> ordered;
        for (const auto& [id, instance] : entry.own) ordered[id] = instance.get();
        for (const auto& [id, instance] : ordered) {
            ByteWriter state;
            instance->save(state);
            own.write(id);
            own.write_block(state.view());
        }
        out.write_block(own.view());
    }
}

void CodeModules::load(Subdomain& subdomain, bool shared, ByteReader& in) {
    for (Entry& entry : modules_) {
        ByteReader common(in.read_block(), "the state of a hand-written module");
        if (shared) entry.shared->load(common);
        for (ByteReader own(in.read_block(), "the states of hand-written modules"); !own.done();) load_own(subdomain, entry, own);
    }
}

void CodeModules::follow(Subdomain& subdomain) {
    for (Entry& entry : modules_)
        if (entry.shared->instances() == CodeModule::Instances::PerCatom) follow(subdomain, entry);
}

// An instance without its catom is offered to all processes; the one that now owns the catom takes it.
void CodeModules::follow(Subdomain& subdomain, Entry& entry) {
    ByteWriter leaving;
    for (auto it = entry.own.begin(); it != entry.own.end();) {
        const std::optional<Catom> catom = subdomain.ensemble.find(it->first);
        if (catom && subdomain.owned(*catom)) {
            ++it;
            continue;
        }
        ByteWriter state;
        it->second->save(state);
        leaving.write(it->first);
        leaving.write_block(state.view());
        it = entry.own.erase(it);
    }
    for (const auto& from : subdomain.comm.allgather_any(leaving.view())) {
        ByteReader in(from, "hand-written modules that follow their catoms");
        while (!in.done()) load_own(subdomain, entry, in);
    }
}

// The state of one catom's module, if this process owns the catom.
void CodeModules::load_own(Subdomain& subdomain, Entry& entry, ByteReader& in) const {
    const auto id = in.read<std::uint64_t>();
    ByteReader state(in.read_block(), "the state of a hand-written module");
    const std::optional<Catom> catom = subdomain.ensemble.find(id);
    if (!catom || !subdomain.owned(*catom)) return;
    std::unique_ptr<CodeModule> instance = instance_of(entry, subdomain.module);
    instance->load(state);
    MELD_CHECK(state.done(), "the module of catom @{} leaves {} bytes of its saved state unread", id, state.left());
    entry.own[id] = std::move(instance);
}

}  // namespace meld::sim
