// What elements do to nodes (core/surfaces/element_rule.hpp).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "core/surfaces/element_rule.hpp"

using namespace moraine;

namespace {

constexpr int nodes = SurfaceElement<2>::nodes, in_tile = 36;

/// The nodes of one cell, that elements share.
struct CellNodes : NodesInTurn<2> {
    double value[in_tile][2 * quad] = {}, lanes[in_tile][2 * quad] = {};

    const double* values(int at) const { return value[at]; }
    SurfaceShares<2> shares(int at) const { return shares_of<2>(lanes[at]); }
    double energy() const {
        double sum = 0;
        each_node<2, 3>([&](int at, int, int, int) {
            const double* v = value[at];
            sum += 0.5 * v[quad - 1] * (v[0] * v[0] + v[1] * v[1]);
        });
        return sum;
    }
    void give(const SurfaceElement<2>& e, const Vec<double, 2>& impulse) {
        int i = 0;
        each_node<2, 3>([&](int at, int, int, int) {
            for (int a = 0; a < 2; ++a) value[at][a] -= e.weight[i] * impulse[a] / value[at][quad - 1];
            ++i;
        });
    }
};

template <class Draw>
SurfaceElement<2> drawn_element(Draw& draw) {
    SurfaceElement<2> e{};
    e.area = draw(0.1, 1);
    const double turn = draw(0, 6.28);
    e.normal = {std::cos(turn), std::sin(turn)};
    double all = 0;
    for (double& w : e.own) all += w = draw(0, 1);
    for (int i = 0; i < nodes; ++i) e.weight[i] = e.own[i] /= all;
    SurfaceNode<2> slave{};
    slave.slaved = draw(0, 1), slave.to[draw(0, 1) < 0.5 ? 0 : 1] = 1;
    give_away(slave, 0, e);
    e.gap = draw(-0.1, 0), e.covered = 1, e.friction = draw(0, 1), e.touches = true;
    return e;
}

}  // namespace

TEST_CASE("elements that share light nodes with slaves give no energy, in either sweep") {
    std::mt19937_64 random(5);
    const auto draw = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
    Structure<2> structure{};
    for (InterfaceLaw law : {InterfaceLaw::smooth, InterfaceLaw::rough, InterfaceLaw::coulomb})
        for (int k = 0; k < 2000; ++k) {
            structure.law = law;
            const SurfaceElement<2> elements[] = {drawn_element(draw), drawn_element(draw), drawn_element(draw)};
            CellNodes cell;
            each_node<2, 3>([&](int at, int, int, int) {
                for (int a = 0; a < 2; ++a) cell.value[at][a] = draw(-1, 1);
                cell.value[at][quad - 1] = std::exp(draw(-16, 0));
            });
            for (const SurfaceElement<2>& e : elements) {
                int i = 0;
                each_node<2, 3>([&](int at, int, int, int) {
                    for (int q = 0; q <= SurfaceShares<2>::count; ++q)
                        cell.lanes[at][sum_lane<2>(q)] += share_lane(e, i, q);
                    ++i;
                });
            }
            const ContactTime time{1e-3, 1e-3};
            for (const ContactTime& sweep : {time, time.second()}) {
                const double before = cell.energy();
                Vec<double, 2> given[3];
                for (int n = 0; n < 3; ++n)
                    given[n] = act_on_element(elements[n], structure, sweep, 0, 0.1, cell).given;
                for (int n = 0; n < 3; ++n) cell.give(elements[n], given[n]);
                CHECK(cell.energy() <= before * (1 + 1e-12));
            }
        }
}

TEST_CASE("slaves that follow one node give no energy together") {
    std::mt19937_64 random(7);
    const auto draw = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
    constexpr int count = 3, nodes = 1 + 2 * count;  // the master, slaves, and the nodes beyond it
    double most_alone = 0;
    for (int k = 0; k < 2000; ++k) {
        double value[nodes][quad];
        value[0][quad - 1] = 1;
        for (int n = 1; n < nodes; ++n) value[n][quad - 1] = n <= count ? draw(0.1, 0.5) : draw(0.5, 4);
        for (int n = 0; n < nodes; ++n)
            for (int a = 0; a < 2; ++a) value[n][a] = n == 0 ? draw(-1, 1) : draw(-0.1, 0.1);
        double slaved[count], all = 0;
        for (double& f : slaved) all += 2 * (f = draw(0.6, 1));
        const auto energy = [&](bool by_row) {
            double after[nodes][quad];
            std::memcpy(after, value, sizeof after);
            for (int s = 0; s < count; ++s) {
                SlaveNode<2> slave{};
                slave.surface.slaved = slaved[s];
                if (by_row) slave.beside[1] = all - 2 * slaved[s];
                const int own = 1 + s, two = 1 + count + s;
                const Vec<double, 2> given =
                    slave_impulse(slave, InterfaceLaw::rough, value[own], value[0], value[two]);
                for (int a = 0; a < 2; ++a) {
                    after[own][a] += given[a] / value[own][quad - 1];
                    after[0][a] -= 2 * given[a] / value[0][quad - 1];
                    after[two][a] += given[a] / value[two][quad - 1];
                }
            }
            double sum = 0;
            for (const auto& v : after) sum += 0.5 * v[quad - 1] * (v[0] * v[0] + v[1] * v[1]);
            return sum;
        };
        double before = 0;
        for (const auto& v : value) before += 0.5 * v[quad - 1] * (v[0] * v[0] + v[1] * v[1]);
        CHECK(energy(true) <= before * (1 + 1e-12));
        most_alone = std::max(most_alone, energy(false) / before);
    }
    CHECK(most_alone > 1.01);  // by their own answers alone
}

TEST_CASE("an element is covered by rows that stretch along it, and wholly at most where a drag acts") {
    ContactField<2> field{};
    field.cell = 1;
    const auto covered = [&](double stretch, InterfaceLaw law) {  // rows as wide and as much nearer to one another
        const double side = 0.5;
        double faces = 0;
        for (int row = 0; row < 4; ++row)
            faces += gap_at<double, 2>(field, lying_on_elements(), side * (0.5 + row / stretch), side * side, 0.0).area;
        NodeGap gap{0, NodeGap::fixed_area(faces / (side * stretch))};
        SurfaceElement<2> e{};
        e.area = 1;
        take_gap(gap, 1, law, e);
        return e.covered;
    };
    CHECK(covered(1, InterfaceLaw::voellmy) == doctest::Approx(1));
    for (double stretch = 1; stretch < 3; stretch += 0.05) {
        CHECK(covered(stretch, InterfaceLaw::voellmy) > 0.85);  // 0.5 by the lowest row alone
        CHECK(covered(stretch, InterfaceLaw::voellmy) <= 1);
        CHECK(covered(stretch, InterfaceLaw::undrained) < 1.1);
    }
    CHECK(covered(0.5, InterfaceLaw::voellmy) == doctest::Approx(1));  // pressed along the bed
    CHECK(covered(0.5, InterfaceLaw::undrained) == doctest::Approx(2));
}
