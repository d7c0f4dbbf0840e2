#pragma once
// What --transport may name besides auto: the transports between devices (gpu/transport), in the order in which auto
// tries them. The last works everywhere. A program without device code knows them too, to say what it lacks.

#include <array>
#include <string_view>

namespace moraine {

inline constexpr std::array<std::string_view, 5> transport_names{"peer", "mixed", "nccl", "mpi", "host"};

}  // namespace moraine
