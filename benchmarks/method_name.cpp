#include "method_name.hpp"

#include <fmt/format.h>

namespace moraine {

std::string method_name(Shape shape, Transfer transfer, StressUpdate update, int order) {
    constexpr const char* shapes[] = {"linear", "gimp", "gimp-contiguous", "quadratic", "cubic"};
    constexpr const char* transfers[] = {"FLIP", "PIC", "APIC", "TPIC", "FMPM", "AFLIP"};
    constexpr const char* updates[] = {"USL", "USF", "MUSL"};
    if (transfer == Transfer::fmpm) return fmt::format("{} FMPM({})", shapes[static_cast<int>(shape)], order);
    return fmt::format("{} {} {}", shapes[static_cast<int>(shape)], transfers[static_cast<int>(transfer)],
                       updates[static_cast<int>(update)]);
}

}  // namespace moraine
