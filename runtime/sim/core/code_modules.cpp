#include "runtime/sim/core/code_modules.h"

#include "runtime/sim/core/bytes.h"

namespace meld::sim {

Result<void> CodeModules::add(const Registry::MakeCode& make, const world::World& world) {
    world_ = &world;
    Result<std::unique_ptr<CodeModule>> module = make(world);
    if (!module) return tl::unexpected<Error>(module.error());
    CodeModule* shared = module->get();
    if (shared->runnable()) modules_.push_back({shared, std::move(*module), make, {}});
    return {};
}

void CodeModules::run(PartState& part) {
    for (Entry& entry : modules_) {
        const bool own = entry.shared->instances() == CodeModule::Instances::PerCatom;
        if (own && !part.alone() && part.world.motion.kind != "none") follow(part, entry);
        for (Catom c = 0; c < part.ensemble.index_count(); ++c) {
            if (!part.owned(c)) continue;
            CatomView view(part, c);
            if (!own) {
                entry.shared->run(view);
                continue;
            }
            std::unique_ptr<CodeModule>& instance = entry.own[part.ensemble.id(c)];
            if (instance == nullptr) instance = std::move(*entry.make(*world_));
            instance->run(view);
        }
    }
}

// An instance without its catom is offered to all parts; the one that owns the catom now takes it.
void CodeModules::follow(PartState& part, Entry& entry) {
    std::vector<std::byte> leaving;
    for (auto it = entry.own.begin(); it != entry.own.end();) {
        const std::optional<Catom> catom = part.ensemble.find(it->first);
        if (catom && part.owned(*catom)) {
            ++it;
            continue;
        }
        const std::vector<std::byte> state = it->second->save();
        put(leaving, it->first);
        put(leaving, static_cast<std::uint32_t>(state.size()));
        leaving.insert(leaving.end(), state.begin(), state.end());
        it = entry.own.erase(it);
    }
    for (const auto& from : part.comm.allgather_any(leaving)) {
        const std::byte* at = from.data();
        while (at != from.data() + from.size()) {
            const auto id = take_value<std::uint64_t>(at);
            const auto size = take_value<std::uint32_t>(at);
            const std::vector<std::byte> state(at, at + size);
            at += size;
            const std::optional<Catom> catom = part.ensemble.find(id);
            if (!catom || !part.owned(*catom)) continue;
            auto instance = std::move(*entry.make(*world_));
            instance->load(state);
            entry.own[id] = std::move(instance);
        }
    }
}

}  // namespace meld::sim
