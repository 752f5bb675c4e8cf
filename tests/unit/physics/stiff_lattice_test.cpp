// Forces in lattices of beams: in balance at every body, against a solution by a dense matrix, and however large.
#include "physics/statics/stiff_lattice.h"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace meld::physics {
namespace {

struct Lattice {
    std::vector<Vec3> places;
    std::vector<Beam> beams;
    void join(std::uint32_t one, std::uint32_t other) {
        const Vec3 way = places[other] - places[one];
        beams.push_back({.one = one, .other = other, .at = places[one] + 0.5 * way, .along = (1 / length(way)) * way});
    }
    void hold(std::uint32_t one, Vec3 along) {
        beams.push_back({.one = one, .other = kGround, .at = places[one] + 0.5 * along, .along = along});
    }
};

// Bodies on a cubic lattice, all neighbours joined but for a share left out at random.
Lattice box(int nx, int ny, int nz, double left_out = 0) {
    Lattice made;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto at = [&](int x, int y, int z) { return std::uint32_t((z * ny + y) * nx + x); };
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x) made.places.push_back({double(x), double(y), double(z)});
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x) {
                // The lines along x hold everything together.
                if (x + 1 < nx) made.join(at(x, y, z), at(x + 1, y, z));
                if (y + 1 < ny && (x == 0 || unit(random) >= left_out)) made.join(at(x, y, z), at(x, y + 1, z));
                if (z + 1 < nz && (x == 0 || unit(random) >= left_out)) made.join(at(x, y, z), at(x, y, z + 1));
            }
    return made;
}

std::vector<Pull> pulls_on(const Lattice& lattice, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Pull> acts;
    for (std::size_t i = 0; i < lattice.places.size(); ++i)
        acts.push_back({{unit(random), unit(random), unit(random) - 5}, {unit(random), unit(random), unit(random)}});
    return acts;
}

// How far the beams are from balancing what acts, relative to the greatest force of a beam.
double imbalance(const Lattice& lattice, const std::vector<Pull>& acts, const std::vector<Pull>& by_beams) {
    std::vector<Pull> left = acts;
    double most = 0;
    for (std::size_t b = 0; b < by_beams.size(); ++b) {
        const Beam& beam = lattice.beams[b];
        const Pull& pull = by_beams[b];
        most = std::max({most, length(pull.force), length(pull.torque)});
        const auto add = [&](std::uint32_t body, double side) {
            left[body].force = left[body].force + side * pull.force;
            left[body].torque = left[body].torque + side * (pull.torque + cross(beam.at - lattice.places[body], pull.force));
        };
        add(beam.one, 1);
        if (beam.other != kGround) add(beam.other, -1);
    }
    double worst = 0;
    for (const Pull& pull : left) worst = std::max({worst, length(pull.force), length(pull.torque)});
    return worst / most;
}

TEST(StiffLattice, BalancesLatticesOfAllShapes) {
    struct LatticeCase {
        int nx, ny, nz;
        double left_out;
    };
    // Rows, ladders, decks, plates and blocks; the larger ones are solved by conjugate gradients.
    for (const auto& [nx, ny, nz, left_out] :
         {LatticeCase{30, 1, 1, 0}, LatticeCase{2, 2, 1, 0}, LatticeCase{200, 2, 1, 0}, LatticeCase{400, 5, 1, 0.3},
          LatticeCase{70, 70, 1, 0}, LatticeCase{16, 16, 16, 0}, LatticeCase{14, 14, 14, 0.6}, LatticeCase{100, 6, 6, 0.2}}) {
        Lattice lattice = box(nx, ny, nz, left_out);
        for (int z = 0; z < nz; ++z)
            for (int y = 0; y < ny; ++y) lattice.hold(std::uint32_t((z * ny + y) * nx), {-1, 0, 0});
        const std::vector<Pull> acts = pulls_on(lattice, 3);
        const StiffLattice stiff(lattice.places, lattice.beams);
        std::vector<Pull> by_beams(lattice.beams.size());
        EXPECT_TRUE(stiff.solve(acts, by_beams)) << nx << ' ' << ny << ' ' << nz;
        EXPECT_LT(imbalance(lattice, acts, by_beams), 1e-5) << nx << ' ' << ny << ' ' << nz;
    }
}

TEST(StiffLattice, BalancesWhatNothingHolds) {
    Lattice lattice = box(8, 7, 6);
    std::vector<Pull> acts = pulls_on(lattice, 5);
    Pull sum;
    for (std::size_t i = 0; i < acts.size(); ++i) {
        sum.force = sum.force + acts[i].force;
        sum.torque = sum.torque + (acts[i].torque + cross(lattice.places[i], acts[i].force));
    }
    acts[50].force = acts[50].force - sum.force;
    acts[50].torque = acts[50].torque - (sum.torque - cross(lattice.places[50], sum.force));
    const StiffLattice stiff(lattice.places, lattice.beams);
    std::vector<Pull> by_beams(lattice.beams.size());
    EXPECT_TRUE(stiff.solve(acts, by_beams));
    EXPECT_LT(imbalance(lattice, acts, by_beams), 1e-6);
}

// Radii differ, so that forces divide by the stiffness of each beam.
TEST(StiffLattice, IsTheSolutionOfADenseMatrix) {
    Lattice lattice = box(3, 2, 3, 0.3);
    lattice.hold(0, {-1, 0, 0}), lattice.hold(7, {0, 0, -1});
    std::mt19937 random(3);
    for (Beam& beam : lattice.beams) beam.radius_m = std::uniform_real_distribution<double>(0.3, 0.9)(random);
    const std::size_t bodies = lattice.places.size();
    // As docs/physics.md says, relative to the stiffness along: 0.4 across, r^2/4 in bending, r^2/5 in torsion.
    const auto stiffness_of = [](const Beam& beam) {
        const Eigen::Vector3d e(beam.along.x, beam.along.y, beam.along.z);
        const Eigen::Matrix3d along = e * e.transpose(), across = Eigen::Matrix3d::Identity() - along;
        Matrix6 m = Matrix6::Zero();
        m.topLeftCorner<3, 3>() = along + 0.4 * across;
        m.bottomRightCorner<3, 3>() = beam.radius_m * beam.radius_m * (0.25 * across + 0.2 * along);
        return m;
    };
    // How the ends of a beam move against each other, as a matrix over all bodies.
    const auto moves = [&](const Beam& beam) {
        Eigen::MatrixXd m = Eigen::MatrixXd::Zero(6, Eigen::Index(6 * bodies));
        m.middleCols<6>(6 * beam.one) = -displacement(beam.at - lattice.places[beam.one]);
        if (beam.other != kGround) m.middleCols<6>(6 * beam.other) = displacement(beam.at - lattice.places[beam.other]);
        return m;
    };
    const std::vector<Pull> acts = pulls_on(lattice, 5);
    Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(Eigen::Index(6 * bodies), Eigen::Index(6 * bodies));
    Eigen::VectorXd force(Eigen::Index(6 * bodies));
    for (std::size_t b = 0; b < bodies; ++b) force.segment<6>(Eigen::Index(6 * b)) = six(acts[b].force, acts[b].torque);
    for (const Beam& beam : lattice.beams) stiffness += moves(beam).transpose() * stiffness_of(beam) * moves(beam);
    const Eigen::VectorXd moved = stiffness.ldlt().solve(force);
    std::vector<Pull> by_beams(lattice.beams.size());
    EXPECT_TRUE(StiffLattice(lattice.places, lattice.beams).solve(acts, by_beams));
    for (std::size_t b = 0; b < by_beams.size(); ++b) {
        const Vector6 expected = stiffness_of(lattice.beams[b]) * (moves(lattice.beams[b]) * moved);
        EXPECT_LT((six(by_beams[b].force, by_beams[b].torque) - expected).norm(), 1e-6 * force.norm()) << "beam " << b;
    }
}

// Where rounding leaves too much of a solution, it says so; where not, all is in balance.
TEST(StiffLattice, SaysWhereAShapeIsTooSlender) {
    for (const int length : {300, 3000, 30000}) {
        Lattice ladder = box(length, 2, 1);
        ladder.hold(0, {-1, 0, 0}), ladder.hold(std::uint32_t(length), {-1, 0, 0});
        const std::vector<Pull> acts(ladder.places.size(), Pull{{0, 0, -9.81}, {}});
        std::vector<Pull> by_beams(ladder.beams.size());
        const bool found = StiffLattice(ladder.places, ladder.beams).solve(acts, by_beams);
        if (found) {
            EXPECT_NEAR(by_beams[by_beams.size() - 1].force.z + by_beams[by_beams.size() - 2].force.z, 2 * length * 9.81,
                        1e-3 * 2 * length * 9.81);
        }
        EXPECT_TRUE(found || length > 300) << length;
    }
}

TEST(StiffLattice, SharesLoadsAsParallelBarsDo) {
    // Three bodies in a row on a post each.
    Lattice lattice;
    lattice.places = {{0, 0, 1}, {1, 0, 1}, {2, 0, 1}};
    lattice.join(0, 1), lattice.join(1, 2);
    for (std::uint32_t i = 0; i < 3; ++i) lattice.hold(i, {0, 0, -1});
    const StiffLattice stiff(lattice.places, lattice.beams);
    std::vector<Pull> by_beams(5);
    EXPECT_TRUE(stiff.solve(std::vector<Pull>{{{0, 0, -3}, {}}, {{0, 0, -3}, {}}, {{0, 0, -3}, {}}}, by_beams));
    for (int post = 2; post < 5; ++post) EXPECT_NEAR(by_beams[std::size_t(post)].force.z, 3, 1e-9);
    EXPECT_TRUE(stiff.solve(std::vector<Pull>{{{0, 0, -6}, {}}, {{0, 0, 0}, {}}, {{0, 0, -6}, {}}}, by_beams));
    EXPECT_NEAR(by_beams[2].force.z, by_beams[4].force.z, 1e-9);
    // The middle takes part of it: as springs side by side, joined by bars that shear and bend, less than the outer two.
    EXPECT_GT(by_beams[3].force.z, 1);
    EXPECT_LT(by_beams[3].force.z, 4);
    EXPECT_NEAR(by_beams[2].force.z + by_beams[3].force.z + by_beams[4].force.z, 12, 1e-9);
}

}  // namespace
}  // namespace meld::physics
