#include "gpu/kernels/programs.hpp"

#include "compile/law_file.hpp"
#include "core/material/laws.hpp"

namespace moraine::gpu {

namespace {

std::string real_of(const KernelKey& key) {
    return key.real == Precision::single_ ? "float" : "double";
}

std::string dim_of(const KernelKey& key) {
    return std::to_string(key.dimension);
}

/// Precision and dimension, as templates begin.
std::string real_dim(const KernelKey& key) {
    return real_of(key) + ", " + dim_of(key);
}

/// A shape function as a type: in moraine, for gpu has names that are alike.
std::string shape_of(const KernelKey& key) {
    switch (key.shape) {
        case Shape::linear:
            return "moraine::Linear";
        case Shape::quadratic:
            return "moraine::Quadratic";
        case Shape::cubic:
            return "moraine::Cubic";
        default:
            return "moraine::Gimp";
    }
}

std::string word(bool value) {
    return value ? "true" : "false";
}

std::string law_at(const KernelKey& key, std::size_t material) {
    const LawInfo& law = *key.laws[material].info;
    if (law.of_file()) return law.file.type + ("<" + real_of(key) + ">");
    const std::string known = "LawAt<" + real_of(key) + ", " + std::to_string(law.position) + ">";
    if (!law.uniform) return known;
    return "OfMask<" + known + ", " + std::to_string(static_cast<int>(law.tail[0])) + ">";
}

/// The text of a law in a file, which its program begins with. Two of a scene have structs of one name: each gets its
/// own. What the file includes is there already where it is a header of laws, and its standard headers do not say Law.
std::vector<std::string> law_texts(const KernelKey& key, std::size_t material) {
    const LawFile& file = key.laws[material].info->file;
    if (!file.text) return {};
    return {std::string("#define Law ") + file.type + "\n#line 1 " + quoted_path(file.path) + "\n" + file.text +
            "\n#line 1 \"kernels.cu\"\n#undef Law\n"};
}

/// The law of a material as a type: with an undrained strength that is constant, one that asks for nothing else.
std::string law_of(const KernelKey& key, std::size_t material) {
    return key.laws[material].plain ? "Plain<" + law_at(key, material) + ">" : law_at(key, material);
}

std::string team_threads(const KernelKey& key) {
    return "Team<" + dim_of(key) + ">::block_threads";
}

std::string team_bytes(const KernelKey& key, const std::string& shared) {
    return "sizeof(" + shared + ") * Team<" + dim_of(key) + ">::per_block";
}

/// A gather with its terms (gpu/kernels/g2p/gather_case.cuh).
std::string gather_case(const KernelKey& key, bool averages, bool light) {
    std::string terms = light ? "light_term" : "no_terms";
    if (averages) terms += " | means_term";
    if (key.fluid == FluidGrid::means) terms += " | fluid_term";
    if (key.fluid == FluidGrid::pressure) terms += " | pressure_term";
    if (key.fluid != FluidGrid::none && key.surfaces) terms += " | surface_term";
    if (key.loads) terms += " | load_term";
    return "GatherCase<" + real_dim(key) + ", " + shape_of(key) + ", " + word(key.affine) + ", (" + terms + ")>";
}

ProgramKernel split_kernel(const KernelKey& key, bool averages, bool light) {
    const std::string of = gather_case(key, averages, light);
    return {"g2p_split<" + of + ", split_blocks<" + of + ">()>", team_threads(key),
            team_bytes(key, "SplitGather<" + of + ">::Shared")};
}

ProgramKernel fused_kernel(const KernelKey& key, std::size_t material, bool averages, bool light) {
    const std::string of = gather_case(key, averages, light) + ", " + law_of(key, material);
    return {"g2p_fused<" + of + ", fused_blocks<" + of + ">()>", team_threads(key),
            team_bytes(key, "FusedGather<" + of + ">::Shared")};
}

/// A program whose kernels ask for structures.
Program with_structures(const KernelKey& key, Program program) {
    if (key.turning) program.defines.push_back("MORAINE_TURNS");
    return program;
}

/// Plain and near structures.
void add_pair(Program& program, bool structures, const std::string& before, const std::string& after) {
    program.kernels.push_back({before + "false" + after, "node_threads", "0"});
    if (structures) program.kernels.push_back({before + "true" + after, "node_threads", "0"});
}

}  // namespace

Program p2g_program(const KernelKey& key, bool mean) {
    const std::string of =
        "P2gCase<" + real_dim(key) + ", " + shape_of(key) + ", " + word(key.affine) + ", " + word(mean) + ">";
    const std::string plan = "p2g_plan<" + of + ">()";
    return {"p2g",
            {"gpu/kernels/p2g/p2g_plan.cuh"},
            {{"particles_to_grid<" + of + ", " + plan + ".passes, " + plan + ".stages, " + plan + ".resident>",
              of + "::threads", "shared_bytes<" + of + ", " + plan + ".passes, " + plan + ".stages>()"}}};
}

Program split_program(const KernelKey& key) {
    // Another material may take means of cells: it is asked at run time, but for boxes and cubic splines, where
    // registers would spill (the program refuses such scenes on devices).
    const bool averages = key.fluid == FluidGrid::means ? key.shape == Shape::linear || key.shape == Shape::quadratic
                                                        : key.fluid == FluidGrid::none && key.cell_means;
    Program program{"gather", {"gpu/kernels/g2p/g2p_split.cuh"}, {split_kernel(key, averages, false)}};
    if (key.light_nodes) program.kernels.push_back(split_kernel(key, averages || key.fluid == FluidGrid::none, true));
    return program;
}

Program fused_program(const KernelKey& key, std::size_t material) {
    Program program{"gather with " + key.laws[material].name,
                    {"core/material/law_list.hpp", "gpu/kernels/g2p/g2p_fused.cuh", "gpu/kernels/g2p/plain_law.cuh"},
                    {fused_kernel(key, material, key.laws[material].cell_means, false)},
                    law_texts(key, material)};
    if (key.light_nodes && key.way == GatherWay::fused)
        program.kernels.push_back(fused_kernel(key, material, key.fluid == FluidGrid::none, true));
    return program;
}

Program limited_program(const KernelKey& key) {
    return {"light nodes",
            {"gpu/kernels/g2p/find_limited.cuh"},
            {{"list_marked<" + real_dim(key) + ">", "list_marked_threads", "0"},
             {"find_limited<" + shape_of(key) + ", " + real_dim(key) + ">", team_threads(key), "0"}}};
}

Program stress_program(const KernelKey& key, std::size_t material) {
    const std::string law = law_of(key, material);
    return {"stress of " + key.laws[material].name,
            {"core/material/law_list.hpp", "gpu/kernels/g2p/stress.cuh", "gpu/kernels/g2p/plain_law.cuh"},
            {{"update_stresses<" + real_dim(key) + ", " + law + ", stress_blocks<" + real_of(key) + ", " + law + ">>",
              team_threads(key), team_bytes(key, "StressShared<" + real_dim(key) + ", " + law + ">")}},
            law_texts(key, material)};
}

Program nodes_program(const KernelKey& key, bool marks, bool fluid) {
    Program program{"nodes", {"gpu/kernels/nodes/nodes.cuh"}, {}};
    add_pair(program, key.structures, "nodes_kernel<" + real_dim(key) + ", " + std::to_string(key.width()) + ", ",
             ", " + word(marks) + ", " + word(fluid) + ">");
    return with_structures(key, program);
}

Program pressure_program(const KernelKey& key) {
    const std::string of = "<" + real_dim(key) + ">";
    Program program{"pressure",
                    {"gpu/kernels/pressure/advance_pressures.cuh", "gpu/kernels/pressure/found_pressures.cuh",
                     "gpu/kernels/pressure/pressure_nodes.cuh"},
                    {{"find_pressures_kernel" + of, team_threads(key), team_bytes(key, "FindShared" + of)},
                     {"advance_whole_kernel" + of, "WholeTeam<" + dim_of(key) + ">::block_threads", "0"},
                     {"advance_cut_kernel" + of, team_threads(key), team_bytes(key, "CutShared" + of)}}};
    add_pair(program, key.structures, "hold_nodes_kernel<" + real_dim(key) + ", ", ">");
    add_pair(program, key.structures, "substep_kernel<" + real_dim(key) + ", ", ">");
    return with_structures(key, program);
}

Program surfaces_program(const KernelKey& key) {
    Program program{"surfaces", {"gpu/kernels/surfaces/surface_gaps.cuh", "gpu/kernels/surfaces/elements.cuh"}, {}};
    for (const char* name :
         {"surface_gaps", "weigh_elements", "sum_shares", "act_on_elements", "close_slaves", "apply_impulses"})
        program.kernels.push_back({name + ("_kernel<" + real_dim(key) + ">"), "surface_threads", "0"});
    if (key.fluid != FluidGrid::pressure) return with_structures(key, program);
    for (const char* header : {"gpu/kernels/surfaces/open_cells.cuh", "gpu/kernels/surfaces/open_substeps.cuh"})
        program.headers.push_back(header);
    for (const char* name : {"keep_held", "find_open_cells", "sum_pass", "weigh_open_cells", "close_open_cells",
                             "fill_open_holes", "press_open_cells", "hold_forces", "find_fluxes"})
        program.kernels.push_back({name + ("_kernel<" + real_dim(key) + ">"), "surface_threads", "0"});
    return with_structures(key, program);
}

Program loads_program(const KernelKey& key) {
    return {"tractions",
            {"gpu/kernels/loads/add_loads.cuh"},
            {{"loads_kernel<" + real_dim(key) + ", " + shape_of(key) + ">", "load_threads", "0"}}};
}

Program waves_program(const KernelKey& key, std::size_t material) {
    return {"waves of " + key.laws[material].name,
            {"core/material/law_list.hpp", "gpu/kernels/g2p/plain_law.cuh", "gpu/kernels/sleep/waves.cuh"},
            {{"waves_kernel<" + real_dim(key) + ", " + law_at(key, material) + ">", "sleep_threads", "0"}},
            law_texts(key, material)};
}

std::vector<Program> programs_of(const KernelKey& key) {
    std::vector<Program> programs{p2g_program(key, key.fluid != FluidGrid::none)};
    const std::size_t materials = key.laws.size();
    if (key.way == GatherWay::fused) {
        programs.push_back(fused_program(key, 0));
    } else {
        programs.push_back(split_program(key));
        for (std::size_t m = 0; m < materials; ++m) programs.push_back(stress_program(key, m));
    }
    if (key.way == GatherWay::by_material)
        for (std::size_t m = 0; m < materials; ++m) programs.push_back(fused_program(key, m));
    if (key.light_nodes) programs.push_back(limited_program(key));
    if (key.fluid == FluidGrid::pressure) {
        programs.push_back(pressure_program(key));
    } else if (key.fluid == FluidGrid::means) {
        programs.push_back(nodes_program(key, true, true));
    } else {
        if (key.light_nodes) programs.push_back(nodes_program(key, true, false));
        if (!key.light_nodes || !key.single_round) programs.push_back(nodes_program(key, false, false));
    }
    if (key.surfaces) programs.push_back(surfaces_program(key));
    if (key.loads) programs.push_back(loads_program(key));
    if (key.sleep)
        for (std::size_t m = 0; m < materials; ++m) programs.push_back(waves_program(key, m));
    return programs;
}

}  // namespace moraine::gpu
