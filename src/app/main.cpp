// moraine: the command line. `run` a scene, `check` it, compile its `kernels`, `converge` it, ask for its `stability`,
// `replay`, `picture` or `report` runs; `schema` is for editors; exit codes say who can mend what went wrong.

#include <fmt/format.h>
#include <malloc.h>
#include <mpi.h>
#include <omp.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <sstream>

#include "app/agreed_scene.hpp"
#include "app/check_report.hpp"
#include "app/device.hpp"
#include "app/driver.hpp"
#include "app/options.hpp"
#include "app/report_page.hpp"
#include "app/step_timing.hpp"
#include "app/watchdog.hpp"
#include "comm/comm.hpp"
#include "compile/system_compiler.hpp"
#include "core/data/error.hpp"
#include "core/data/rank_failure.hpp"
#include "io/disk_file.hpp"
#include "io/file_numbers.hpp"
#include "io/input_error.hpp"
#include "predict/capacity.hpp"
#include "predict/prediction.hpp"
#include "records/version.hpp"
#include "replay/replay.hpp"
#include "scene/scene_changes.hpp"
#include "scene/scene_schema.hpp"

namespace moraine {

namespace {

enum Exit { done = 0, internal_error = 1, input_wrong = 2, physics_wrong = 3, machine_failed = 4, stopped = 5 };

constexpr std::size_t longest_message = 2000;

/// What one error must do: an exit code, and its message, once.
int tell(const Comm& comm, int code, const std::string& message) {
    if (comm.is_root()) fmt::print(stderr, "moraine: {}\n", printable(message, longest_message));
    return code;
}

/// An error of this rank alone: the others cannot know of it, and would wait.
int end_job(const Comm& comm, int code, const std::string& message) {
    fmt::print(stderr, "moraine: {}\n", printable(message, longest_message));
    std::fflush(stderr);
    if (comm.size() > 1) MPI_Abort(MPI_COMM_WORLD, code);
    return code;
}

/// A compiler's error, which has lines.
int tell_lines(const Comm& comm, int code, const std::string& message) {
    std::istringstream lines(message);
    std::string line, text;
    while (text.size() < longest_message && std::getline(lines, line)) {
        text += text.empty() ? "" : "\n";
        text += printable(line, longest_message);
    }
    if (comm.is_root()) fmt::print(stderr, "moraine: {}\n", text);
    return code;
}

/// Where the scene is to run; `check` without --time tells of other machines, whose memory is not known here.
/// Collective.
Machine machine_of(const Comm& comm, const Options& options) {
    Machine machine{comm.size(), comm.on_this_machine().size, host_memory()};
    if (options.command == "check" && !options.time)
        machine = {options.ranks, 1, options.ranks == 1 ? host_memory() : 0};
    machine.devices = wants_device(options.device, comm);
    machine.writes_particles = !options.no_particles;
    return machine;
}

/// What devices do not have (gpu/kernels/programs.cpp).
void check_device_scene(const Scene& scene) {
    for (const MaterialSpec& m : scene.materials)
        if (uses_grid_pressure(scene) && m.volumetric != Volumetric::grid)
            throw InputError(fmt::format(
                "{}: material.{} without volumetric = \"grid\", beside one with it (devices do not have it). Use "
                "--device cpu?",
                scene.source.path, m.name));
    if (scene.water.on)
        throw InputError(fmt::format("{}: [water] (devices do not have it). Use --device cpu?", scene.source.path));
    for (const StructureSpec& s : scene.structures)
        if (s.motion.collision)
            throw InputError(
                fmt::format("{}: structure.{}, which meets others (devices do not have it). Use --device cpu?",
                            scene.source.path, s.name));
    if (scene.output.sleep_forecast)
        throw InputError(
            fmt::format("{}: output.block_loads = \"sleep\" (devices do not have it). Use \"on\"?", scene.source.path));
    if (scene.output.energy_budget)
        throw InputError(fmt::format("{}: output.energy_budget = \"on\" (devices do not have it). Use --device cpu?",
                                     scene.source.path));
    if (scene.shape == Shape::linear || scene.shape == Shape::quadratic) return;
    const auto& all = scene.materials;
    if (std::none_of(all.begin(), all.end(), [](const MaterialSpec& m) { return has_fluid_terms(m); })) return;
    for (const MaterialSpec& m : all)
        if (m.volumetric == Volumetric::cell)
            throw InputError(fmt::format(
                "material.{}.volumetric = \"cell\" with this shape, beside a material with pressure_smoothing or "
                "particle_shifting (devices do not have it). Use shape = \"quadratic\", or --device cpu?",
                m.name));
}

/// Cores are shared out among the ranks of this machine, unless OMP_NUM_THREADS says otherwise: threads
/// that wait for a core that another rank spins on are slower than none. Collective.
void choose_threads(const Comm& comm) {
    if (std::getenv("OMP_NUM_THREADS")) return;
    omp_set_num_threads(std::max(1, omp_get_num_procs() / comm.on_this_machine().size));
}

/// The host's threads, or devices that have space for the scene. Collective.
DeviceChoice prepare_device(const Scene& scene, const Options& options, const Comm& comm) {
    choose_threads(comm);
    keep_kernels(options.kernel_cache, comm.is_root() && !options.quiet);
    const DeviceChoice device = choose_device(options.device, comm, options.transport);
    if (device.cuda) check_device_memory(bytes_on_device(scene, predict(scene), comm.size()), comm);
    return device;
}

void check(const Scene& scene, const Options& options, const Comm& comm, const Machine& machine) {
    CheckedRun run{options.time ? comm.size() : options.ranks, machine.devices, !options.no_particles};
    if (options.time) run.timing = time_steps(scene, comm, prepare_device(scene, options, comm), run.writes_particles);
    if (comm.is_root()) fmt::print("{}", check_report(scene, run));
}

/// run.watchdog as long as no scene is read: of --set, or its default [s].
double first_limit(const Options& options) {
    const std::string key = "run.watchdog=";
    double limit = Watchdog::standard_limit;
    for (const std::string& set : options.sets)
        if (set.starts_with(key)) limit = number_in(set.substr(key.size())).value_or(limit);
    return limit;
}

/// Of a run, from its first message on. Collective.
std::unique_ptr<Watchdog> begin_watch(const Options& options, const Comm& comm) {
    std::unique_ptr<Watchdog> watchdog;
    if (options.command != "run") return watchdog;
    comm.agree_no_error<MachineError>(
        message_of([&] { watchdog = std::make_unique<Watchdog>(comm.rank(), first_limit(options)); }));
    return watchdog;
}

void execute(const Options& options, const Comm& comm) {
    const std::unique_ptr<Watchdog> watchdog = begin_watch(options, comm);
    const Machine machine = machine_of(comm, options);
    const Scene scene = read_agreed(comm, options, [&](const Scene& s) {
        if (watchdog) watchdog->set_limit(s.watchdog);
        if (machine.devices) check_device_scene(s);
        check_allowed(s, options.allow_changes);
        check_capacity(s, machine);
    });
    if (options.command == "check") {
        check(scene, options, comm, machine);
        return;
    }
    if (options.command == "kernels") {
        check_device_scene(scene);
        if (comm.is_root()) fmt::print("{}", compile_kernels(scene, options.kernel_cache, options.architectures));
        return;
    }
    for (const std::string& notice : scene.notices)
        if (comm.is_root() && !options.quiet) fmt::print(stderr, "{}\n", notice);
    run_scene(scene, options, comm, prepare_device(scene, options, comm), *watchdog);
}

int run_program(int argc, char** argv) {
    const Comm comm(MPI_COMM_WORLD);
    try {
        const Options options = parse_options(argc, argv);
        if (options.command == "version") {
            if (comm.is_root()) fmt::print("moraine {} ({})\n", version_text, commit_text);
        } else if (options.command == "help") {
            if (comm.is_root()) fmt::print("{}", help_text(options.topic));
        } else if (options.command == "schema") {
            if (comm.is_root()) fmt::print("{}\n", scene_schema().text());
        } else if (options.command == "replay") {
            if (comm.is_root()) replay(options.replay);
        } else {
            execute(options, comm);
        }
        return done;
    } catch (const CompilerError& e) {
        return tell_lines(comm, input_wrong, e.what());
    } catch (const InputError& e) {
        return tell(comm, input_wrong, e.what());
    } catch (const PhysicsError& e) {
        return tell(comm, physics_wrong, e.what());
    } catch (const Stopped& e) {
        return tell(comm, stopped, e.what());
    } catch (const RankFailure& e) {
        return end_job(comm, machine_failed,
                       comm.size() > 1 ? fmt::format("rank {}: {}", comm.rank(), e.what()) : e.what());
    } catch (const MachineError& e) {
        return tell(comm, machine_failed, e.what());
    } catch (const std::bad_alloc&) {
        return end_job(comm, machine_failed,
                       fmt::format("memory ran out (rank {} wants more than this machine has). More ranks, or a larger "
                                   "domain.cell?",
                                   comm.rank()));
    } catch (const std::system_error& e) {  // no thread, no file: not the same on all ranks
        return end_job(
            comm, machine_failed,
            fmt::format("rank {}: {} (of the system). Raise the limits on memory and processes (ulimit -v, -u)?",
                        comm.rank(), e.what()));
    } catch (const std::exception& e) {
        return end_job(comm, internal_error, fmt::format("rank {}: {}", comm.rank(), e.what()));
    }
}

/// Without mpirun or srun Open MPI shall start no daemon, which takes half the time to begin, and make no folder of
/// sessions: those of ranks without one have one name, and who ends first removes it from under who begins.
void begin_alone() {
    if (std::getenv("PMIX_RANK") || std::getenv("PMI_RANK")) return;
    ::setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
    ::setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
}

}  // namespace

}  // namespace moraine

int main(int argc, char** argv) {
    if (argc > 1 && moraine::is_script(argv[1])) return moraine::become_script(argc, argv);
    if (argc > 2 && std::strcmp(argv[1], "help") == 0 && moraine::is_script(argv[2])) {
        char* words[] = {argv[0], argv[2], const_cast<char*>("--help"), nullptr};
        return moraine::become_script(3, words);
    }
    std::signal(SIGXFSZ, SIG_IGN);       // a limit on file sizes is told by the write that meets it (io/disk_file.cpp)
    mallopt(M_MMAP_THRESHOLD, 1 << 20);  // glibc would raise it, and keep freed columns as holes in the heap
    moraine::begin_alone();
    int provided = 0;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);  // threads compute, one speaks
    const int code = moraine::run_program(argc, argv);
    MPI_Finalize();
    return code;
}
