// Writes a particle series whose content read_vtkhdf.py knows:
//   write_vtkhdf FILE FIRST LAST [PARTICLES] [PAUSE_US]
// Outputs FIRST to LAST - 1 at times k / 10 s; particles leave one by one, and from output 3 on there is
// a field more. An existing file is first cut after output FIRST - 1. Prints "wrote k" after each.

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "io/sample_rows.hpp"
#include "io/vtkhdf.hpp"

using namespace moraine;

namespace {

void write_output(const Comm& comm, ParticleSeries& series, int k, std::int64_t particles) {
    const auto all = sample::blocks(40, (particles + 39) / 40);
    auto left = all;
    left[5].count -= std::min<std::int64_t>(left[5].count, 13 * k);
    const sample::Part part(left, comm.rank(), comm.size(), static_cast<std::uint64_t>(k));
    std::vector<float> pressure;
    std::vector<double> velocity;
    for (const std::uint64_t id : part.id) {
        pressure.push_back(static_cast<float>(sample::number(id, 0)) + static_cast<float>(k));
        velocity.insert(velocity.end(), {static_cast<double>(k), sample::number(id, 1)});
    }
    auto columns = part.columns();
    columns.push_back(Column::of("velocity", "m/s", velocity.data(), 2));
    if (k >= 3) columns.push_back(Column::of("pressure", "Pa", pressure.data()));
    const Column position = columns[1];
    columns.erase(columns.begin() + 1);
    series.append(0.1 * k, part.blocks, position, columns);
    if (comm.is_root()) std::printf("wrote %d\n", k);
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
    MPI_Init(&argc, &argv);
    {
        const Comm comm(MPI_COMM_WORLD);
        ParticleSeries series(comm, argv[1]);
        const int first = std::atoi(argv[2]);
        if (first > 0) series.truncate_to(0.1 * (first - 1));
        for (int k = first; k < std::atoi(argv[3]); ++k) {
            write_output(comm, series, k, argc > 4 ? std::atoll(argv[4]) : 5000);
            if (argc > 5) usleep(static_cast<useconds_t>(std::atoi(argv[5])));
        }
    }
    MPI_Finalize();
    return 0;
}
