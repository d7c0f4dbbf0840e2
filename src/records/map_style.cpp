#include "records/map_style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace moraine {
namespace {

constexpr std::size_t steps = 8;
using Ramp = std::array<const char*, steps>;
// ColorBrewer's YlGnBu, YlOrRd and YlOrBr, and viridis from its bright end: all are told apart by the red-green blind.
constexpr Ramp blues{"#edf8b1", "#c7e9b4", "#7fcdbb", "#41b6c4", "#1d91c0", "#225ea8", "#253494", "#081d58"};
constexpr Ramp reds{"#ffeda0", "#fed976", "#feb24c", "#fd8d3c", "#fc4e2a", "#e31a1c", "#bd0026", "#800026"};
constexpr Ramp browns{"#fff7bc", "#fee391", "#fec44f", "#fe9929", "#ec7014", "#cc4c02", "#993404", "#662506"};
constexpr Ramp times{"#fde725", "#a0da39", "#4ac16d", "#1fa187", "#277f8e", "#365c8d", "#46327e", "#440154"};

const Ramp& ramp_of(const std::string& map) {
    if (map == "arrival") return times;
    if (map.starts_with("deposit")) return browns;
    return map == "max_depth" || map == "max_thickness" ? blues : reds;
}

/// The largest of 1, 2, 5 times a power of ten that is not larger.
double round_down(double value) {
    const double ten = std::pow(10, std::floor(std::log10(value)));
    return ten * (value >= 5 * ten ? 5 : value >= 2 * ten ? 2 : 1);
}

/// Upper ends of all steps but the last, rising.
std::vector<double> ends_of(const std::string& map, double most) {
    std::vector<double> ends;
    if (!(most > 0)) return ends;
    if (map == "arrival") {
        const double even = round_down(most / (steps - 3));
        for (std::size_t k = 1; k < steps && static_cast<double>(k) * even < most; ++k)
            ends.push_back(static_cast<double>(k) * even);
        return ends;
    }
    for (double end = round_down(most * (1 - 1e-9)); ends.size() + 1 < steps; end = round_down(end * (1 - 1e-9)))
        ends.push_back(end);
    std::reverse(ends.begin(), ends.end());
    return ends;
}

std::string item(const std::string& value, const char* colour, const std::string& label) {
    return fmt::format("          <item value=\"{}\" color=\"{}\" alpha=\"255\" label=\"{}\"/>\n", value, colour,
                       label);
}

}  // namespace

std::string map_style(const std::string& map, double most) {
    const std::vector<double> ends = ends_of(map, most);
    const Ramp& colours = ramp_of(map);
    std::string items;
    for (std::size_t k = 0; k < ends.size(); ++k)
        items +=
            item(fmt::format("{:.6g}", ends[k]), colours[k],
                 k == 0 ? fmt::format("up to {:.6g}", ends[k]) : fmt::format("{:.6g} to {:.6g}", ends[k - 1], ends[k]));
    items += item("inf", colours[ends.size()], ends.empty() ? "reached" : fmt::format("above {:.6g}", ends.back()));
    return fmt::format(
        "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
        "<qgis version=\"3.22\" styleCategories=\"Symbology\">\n  <pipe>\n"
        "    <rasterrenderer type=\"singlebandpseudocolor\" band=\"1\" opacity=\"0.8\" alphaBand=\"-1\" "
        "nodataColor=\"\" classificationMin=\"0\" classificationMax=\"{0:.6g}\">\n      <rastershader>\n"
        "        <colorrampshader colorRampType=\"DISCRETE\" classificationMode=\"1\" clip=\"0\" minimumValue=\"0\" "
        "maximumValue=\"{0:.6g}\">\n{1}        </colorrampshader>\n      </rastershader>\n    </rasterrenderer>\n"
        "  </pipe>\n  <blendMode>0</blendMode>\n</qgis>\n",
        most, items);
}

}  // namespace moraine
