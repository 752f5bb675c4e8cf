// Which block has a copy of which composite, and how velocities get into the copies and back.
#include "physics/solver/composite_rows.h"

#include <algorithm>

#include "physics/bodies/denormals.h"
#include "physics/solver/turning/turning_lanes.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kRowBlocksPerJob = 4, kCopiedPerJob = 256;

std::size_t jobs_of(std::size_t count, std::size_t per_job) { return (count + per_job - 1) / per_job; }

}  // namespace

template <class F>
void CompositeRows::each_stretch(Contacts& contacts, std::size_t block, const F& f) {
    CompositeRow* rows = rows_.data() + first_row_[block];
    const auto joint = contacts.joint_pairs(block), mixed = contacts.mixed_pairs(block), obstacles = contacts.mixed_obstacles(block);
    const Lanes* held = contacts.adhesion.empty() ? nullptr : contacts.adhesion.data() + contacts.first_pair_batch(block);
    const std::size_t plain = contacts.plain_pairs(block).size();
    const auto behind = [held](std::size_t batches) { return held == nullptr ? nullptr : held + batches; };
    if (!joint.empty()) f(RowKind::Joint, joint, rows, behind(plain));
    if (!mixed.empty()) f(RowKind::Mixed, mixed, rows + joint.size(), behind(plain + joint.size()));
    if (!obstacles.empty()) f(RowKind::Mixed, obstacles, rows + joint.size() + mixed.size(), nullptr);
}

void CompositeRows::lay_out(Contacts& contacts, ShapeContacts& shapes, std::size_t blocks, Bodies& bodies, const Composites& composites,
                            Workers& workers) {
    fresh_ = in_copies_ = false;
    rows_.clear(), copies_.clear(), centres_.clear(), composite_of_.clear(), block_of_copy_.clear(), entries_.clear();
    if (composites.all().empty()) return;
    if (!shapes.empty()) lay_out_entries(shapes, blocks, bodies, composites);
    first_row_.assign(blocks + 1, 0);
    for (std::size_t b = 0; b < blocks; ++b)
        first_row_[b + 1] = first_row_[b] + static_cast<std::uint32_t>(contacts.joint_pairs(b).size() + contacts.mixed_pairs(b).size() +
                                                                       contacts.mixed_obstacles(b).size());
    rows_.resize(first_row_[blocks]);
    const auto mover = [&](std::uint32_t slot) {
        return slot < bodies.count() ? composites.mover_of(bodies.properties[slot].id) : kNoComposite;
    };
    const auto each_block = [&](const auto& f) {
        workers.run(jobs_of(blocks, kRowBlocksPerJob), [&](int, std::size_t job) {
            for (std::size_t b = job * kRowBlocksPerJob; b < std::min(blocks, (job + 1) * kRowBlocksPerJob); ++b)
                if (first_row_[b] != first_row_[b + 1]) f(b);
        });
    };
    // Which composites a block copies, in the order of their ids, and one for lanes without a body.
    std::vector<std::vector<std::uint32_t>> here(blocks);
    each_block([&](std::size_t b) {
        std::vector<std::uint32_t>& found = here[b];
        each_stretch(contacts, b, [&](RowKind kind, std::span<const Batch> batches, CompositeRow*, const Lanes*) {
            for (const Batch& batch : batches)
                for (int i = 0; i < kLanes; ++i) {
                    found.push_back(mover(batch.a[i]));
                    if (kind == RowKind::Joint) found.push_back(mover(batch.b[i]));
                }
        });
        found.push_back(kNoComposite);
        std::ranges::sort(found);
        found.erase(std::unique(found.begin(), found.end()), found.end());
    });
    std::vector<std::uint32_t> first(blocks + 1, 0);
    first_copy_.assign(composites.all().size() + 1, 0);
    for (std::size_t b = 0; b < blocks; ++b) {
        first[b + 1] = first[b] + static_cast<std::uint32_t>(here[b].size());
        for (const std::uint32_t composite : here[b]) {
            composite_of_.push_back(composite), block_of_copy_.push_back(static_cast<std::uint32_t>(b));
            if (composite != kNoComposite) ++first_copy_[composite + 1];
        }
    }
    for (std::size_t c = 0; c + 1 < first_copy_.size(); ++c) first_copy_[c + 1] += first_copy_[c];
    copy_of_.resize(first_copy_.back());
    std::vector<std::uint32_t> next(first_copy_.begin(), first_copy_.end() - 1);
    for (std::uint32_t copy = 0; copy < composite_of_.size(); ++copy)
        if (composite_of_[copy] != kNoComposite) copy_of_[next[composite_of_[copy]]++] = copy;
    copies_.assign(composite_of_.size(), CompositeCopy{});
    centres_.assign(composite_of_.size(), Place{});
    each_block([&](std::size_t b) {
        const auto copy = [&](std::uint32_t composite) {
            return first[b] + static_cast<std::uint32_t>(std::ranges::lower_bound(here[b], composite) - here[b].begin());
        };
        each_stretch(contacts, b, [&](RowKind kind, std::span<const Batch> batches, CompositeRow* rows, const Lanes*) {
            for (const Batch& batch : batches) {
                CompositeRow& row = *rows++;
                for (int i = 0; i < kLanes; ++i) {
                    row.a[i] = copy(mover(batch.a[i]));
                    row.b[i] = kind == RowKind::Joint ? copy(mover(batch.b[i])) : first[b + 1] - 1;
                }
            }
        });
    });
}

template <class F>
void CompositeRows::each_copied(Workers& workers, const F& f) const {
    const std::size_t count = first_copy_.size() - 1;
    workers.run(jobs_of(count, kCopiedPerJob), [&](int, std::size_t job) {
        for (std::size_t c = job * kCopiedPerJob; c < std::min(count, (job + 1) * kCopiedPerJob); ++c)
            if (const auto entries = entries_of(c); first_copy_[c] != first_copy_[c + 1] || !entries.empty())
                f(c, std::span(copy_of_).subspan(first_copy_[c], first_copy_[c + 1] - first_copy_[c]), entries);
    });
}

void CompositeRows::begin(Contacts& contacts, ShapeContacts& shapes, std::span<const std::uint32_t> blocks, Bodies& bodies,
                          const Composites& composites, Workers& workers) {
    if (empty() || (in_copies_ && fresh_)) return;
    MELD_EXPECT(!in_copies_, "velocities are in the copies while places change");
    each_copied(workers, [&](std::size_t c, std::span<const std::uint32_t> copies, std::span<const Entry> entries) {
        const Composite& composite = composites.all()[c];
        const auto share = static_cast<double>(copies.size() + entries.size());
        for (const Entry& entry : entries) begin_entry(entry.at, shapes, bodies, composite, share);
        const CompositeMotion& motion = composite.motion;
        CompositeCopy whole{};
        set_single(whole.linear, motion.velocity_m_s), set_single(whole.spin, motion.spin_rad_s);
        if (!fresh_ && composite.moves_freely()) {
            const Symmetric lightness = turned(composite.inverse_inertia, motion.turn);
            whole.inverse_mass = static_cast<float>(share / composite.mass_kg);
            const double numbers[] = {lightness.xx, lightness.xy, lightness.xz, lightness.yy, lightness.yz, lightness.zz};
            for (int i = 0; i < 6; ++i) whole.inverse_inertia[i] = static_cast<float>(share * numbers[i]);
        }
        for (const std::uint32_t copy : copies) {
            if (!fresh_) {
                copies_[copy] = whole;
                centres_[copy] = {motion.centre_m.x, motion.centre_m.y, motion.centre_m.z, 0};
                continue;
            }
            std::copy_n(whole.linear, 3, copies_[copy].linear);
            std::copy_n(whole.spin, 3, copies_[copy].spin);
        }
    });
    in_copies_ = true;
    if (std::exchange(fresh_, true)) return;
    if (!entries_.empty()) place_arms(shapes, blocks, bodies, composites, workers);
    workers.run(jobs_of(blocks.size(), kRowBlocksPerJob), [&](int, std::size_t job) {
        const FlushDenormals flush;
        for (std::size_t i = job * kRowBlocksPerJob; i < std::min(blocks.size(), (job + 1) * kRowBlocksPerJob); ++i)
            each_stretch(contacts, blocks[i], [&](RowKind kind, std::span<const Batch> batches, CompositeRow* rows, const Lanes*) {
                refresh_rows(kind, batches, rows, copies_.data(), centres_.data(), bodies);
            });
    });
}

void CompositeRows::average(Bodies& bodies, Workers& workers) {
    if (empty()) return;
    each_copied(workers, [&](std::size_t, std::span<const std::uint32_t> copies, std::span<const Entry> entries) {
        if (copies.size() + entries.size() == 1) return;
        Vec3 linear, spin;
        for (const std::uint32_t copy : copies) linear = linear + widened(copies_[copy].linear), spin = spin + widened(copies_[copy].spin);
        for (const Entry& entry : entries) {
            const double unit_m = bodies.place[entry.at].radius;
            linear = linear + widened(bodies.velocity[entry.at].linear);
            spin = spin + (1 / unit_m) * widened(bodies.velocity[entry.at].surface);
        }
        const double share = 1 / static_cast<double>(copies.size() + entries.size());
        for (const std::uint32_t copy : copies)
            set_single(copies_[copy].linear, share * linear), set_single(copies_[copy].spin, share * spin);
        for (const Entry& entry : entries) {
            set_single(bodies.velocity[entry.at].linear, share * linear);
            set_single(bodies.velocity[entry.at].surface, (bodies.place[entry.at].radius * share) * spin);
        }
    });
}

// Only what the sweeps have changed is added, so that a composite that nothing touches keeps all digits of its velocity.
void CompositeRows::collect(const Bodies& bodies, Composites& composites, Workers& workers) {
    if (empty() || !std::exchange(in_copies_, false)) return;
    each_copied(workers, [&](std::size_t c, std::span<const std::uint32_t> copies, std::span<const Entry> entries) {
        Composite& composite = composites.all()[c];
        if (!composite.moves_freely()) return;
        CompositeMotion& motion = composite.motion;
        // g++ 12 with -O3 would leave out the rounding to single precision, and the motion would lose the digits below it.
        const auto rounded = [](double value) {
            const volatile float single = static_cast<float>(value);
            return static_cast<double>(single);
        };
        const auto take = [&rounded](Vec3& from, const float(&to)[3], double unit = 1) {
            const Vec3 before = unit * from;
            from = from + (1 / unit) * (widened(to) - Vec3{rounded(before.x), rounded(before.y), rounded(before.z)});
        };
        if (copies.empty()) {
            const BodyVelocity& velocity = bodies.velocity[entries.front().at];
            take(motion.velocity_m_s, velocity.linear);
            take(motion.spin_rad_s, velocity.surface, bodies.place[entries.front().at].radius);
            return;
        }
        take(motion.velocity_m_s, copies_[copies.front()].linear);
        take(motion.spin_rad_s, copies_[copies.front()].spin);
    });
}

void CompositeRows::warm_start(Contacts& contacts, std::uint32_t block, BodyVelocity* velocities) {
    if (empty()) return;
    each_stretch(contacts, block, [&](RowKind kind, std::span<const Batch> batches, const CompositeRow* rows, const Lanes*) {
        warm_start_rows(kind, batches, rows, copies_.data(), velocities);
    });
}

void CompositeRows::sweep(Contacts& contacts, std::uint32_t block, BodyVelocity* velocities, float step_s, const SweepRule& rule) {
    if (empty()) return;
    each_stretch(contacts, block, [&](RowKind kind, std::span<Batch> batches, const CompositeRow* rows, const Lanes* held) {
        sweep_rows(kind, batches, rows, copies_.data(), velocities, held, step_s, rule);
    });
}

void CompositeRows::resist_turning(Contacts& contacts, std::uint32_t block, TurningLanes* pairs, TurningLanes* obstacles,
                                   BodyVelocity* velocities, float step_s, const SweepRule& rule) {
    if (empty()) return;
    TurningLanes* beside = pairs + contacts.plain_pairs(block).size();
    each_stretch(contacts, block, [&](RowKind kind, std::span<const Batch> batches, const CompositeRow* rows, const Lanes* held) {
        // They come last.
        if (batches.data() == contacts.mixed_obstacles(block).data()) beside = obstacles + contacts.plain_obstacles(block).size();
        resist_turning_of_rows(kind, batches, rows, beside, copies_.data(), velocities, held, step_s, rule);
        beside += batches.size();
    });
}

std::size_t CompositeRows::bytes() const {
    return entries_.capacity() * sizeof(Entry) + rows_.capacity() * sizeof(CompositeRow) + copies_.capacity() * sizeof(CompositeCopy) +
           centres_.capacity() * sizeof(Place) +
           (composite_of_.capacity() + block_of_copy_.capacity() + first_row_.capacity() + first_copy_.capacity() + copy_of_.capacity()) *
               sizeof(std::uint32_t);
}

}  // namespace meld::physics
