// Whatever takes long with many catoms gives signs of life, or the supervisor of the run takes it for one that hangs.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "run_fixture.h"
#include "runtime/base/process/liveness.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/results/facts/fact_tables.h"
#include "runtime/results/facts/facts_file.h"
#include "runtime/results/record/recorder.h"
#include "runtime/results/record/state_digest.h"

namespace meld {
namespace {

namespace fs = std::filesystem;

class Liveness : public ProgramTest {
  protected:
    void SetUp() override {
        ProgramTest::SetUp();
        fs::create_directories(folder_);
        liveness::detail::own = &place_;
    }
    void TearDown() override {
        liveness::detail::own = nullptr;
        fs::remove_all(folder_);
    }
    std::string path(const char* name) const { return folder_ / name; }

    // Signs that are given while the work is done.
    template <class Work>
    std::uint64_t during(Work&& work) {
        const std::uint64_t before = place_.beats;
        work();
        return place_.beats - before;
    }

  private:
    liveness::Place place_{};
    const fs::path folder_ = fs::temp_directory_path() / ("liveness_test_" + std::to_string(getpid()));
};

TEST_P(Liveness, BeatsForEachCatom) {
    const auto comm = comm::make_single();
    const ModuleInfo& module = *static_cast<const ModuleInfo*>(module_->table());
    sim::Simulation simulation(module, world_, *target_, *comm, 1);
    ASSERT_TRUE(simulation.start(sim::Registry::standard()).has_value());
    ASSERT_TRUE(simulation.run({GetParam().ticks}, [] {}).has_value());
    sim::Subdomain& subdomain = simulation.subdomain();
    const std::uint64_t catoms = simulation.summary().catoms;
    const std::uint64_t tables = record::fact_tables(module).size();
    EXPECT_GE(during([&] { record::state_digest(subdomain); }), catoms / 4000);
    for (const char* name : {"facts", "tables/", "facts.h5"}) {
        auto file = record::open_facts(path(name), module, Durability::Process);
        ASSERT_TRUE(file.has_value()) << file.error().message();
        // One table after the other.
        EXPECT_GE(during([&] { EXPECT_TRUE(record::write_facts(subdomain, record::facts_form(name), file->get()).has_value()); }),
                  tables * catoms)
            << name;
    }
    record::Recorder recorder(path("run.vtkhdf"), 1, {"dist"}, {});
    // Besides the digest, the rows.
    EXPECT_GT(during([&] { EXPECT_TRUE(recorder.start(subdomain).has_value()); }), catoms);
}

INSTANTIATE_TEST_SUITE_P(Programs, Liveness, testing::Values(Program{.name = "gradient"}), program_name);

}  // namespace
}  // namespace meld
