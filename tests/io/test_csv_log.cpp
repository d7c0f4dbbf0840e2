#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "core/data/error.hpp"
#include "io/csv_log.hpp"
#include "io/disk_file.hpp"
#include "io/test_folder.hpp"

using namespace moraine;

TEST_CASE("what gets no memory says so") {
    CHECK(message_of([] { throw std::bad_alloc(); }).starts_with("memory ran out"));
    CHECK(message_of([] {}).empty());
}

TEST_CASE("a row reads back to the same bits, and is on the disk at once") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    CsvLog log(comm, folder / "h.csv", {"step", "time_s", "x_m"});
    log.begin();
    const double values[] = {12, 0.1 + 0.2, -4.9406564584124654e-324};
    log.row(comm.is_root() ? std::span<const double>(values) : std::span<const double>());
    if (comm.is_root()) {
        std::istringstream text(content_of(folder / "h.csv"));
        std::string line;
        std::getline(text, line);
        CHECK(line == "step,time_s,x_m");
        for (const double value : values) {
            std::getline(text, line, value == values[2] ? '\n' : ',');
            CHECK(std::strtod(line.c_str(), nullptr) == value);
        }
    }
    const double huge[] = {1e15, std::numeric_limits<double>::quiet_NaN(), 1};
    log.row(huge);
    CHECK(content_of(folder / "h.csv").find("\n1000000000000000,nan,1\n") != std::string::npos);
}

TEST_CASE("a row may hold words, and is kept or dropped like any other") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "b.csv";
    {
        CsvLog log(comm, path, {"step", "reason", "gain"});
        log.begin();
        log.row(std::vector<CsvCell>{1.0, "no better plan", 0.5});
        log.row(std::vector<CsvCell>{2.0, "", std::numeric_limits<double>::quiet_NaN()});
    }
    CHECK(content_of(path) == "step,reason,gain\n1,no better plan,0.5\n2,,nan\n");
    comm.barrier();
    CsvLog resumed(comm, path, {"step", "reason", "gain"}, ResumeAfter{"step", 1});
    resumed.begin();
    CHECK(content_of(path) == "step,reason,gain\n1,no better plan,0.5\n");
}

TEST_CASE("a resumed table keeps the rows up to the checkpoint and drops later and torn ones") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "h.csv";
    if (comm.is_root()) set_content(path, "step,time_s\n1,0.1\n2,0.2\n3,0.30000000000000004\nrubbish\n4,0.4\n5,0.");
    comm.barrier();
    CsvLog log(comm, path, {"step", "time_s"}, ResumeAfter{"time_s", 0.1 + 0.2});
    CHECK(content_of(path).ends_with("5,0."));  // until it is to begin
    comm.barrier();
    log.begin();
    CHECK(content_of(path) == "step,time_s\n1,0.1\n2,0.2\n3,0.30000000000000004\n");
    comm.barrier();
    const double next[] = {4, 0.5};
    log.row(next);
    CHECK(content_of(path) == "step,time_s\n1,0.1\n2,0.2\n3,0.30000000000000004\n4,0.5\n");
    comm.barrier();
    CHECK_THROWS_AS(CsvLog(comm, path, {"step", "x_m"}, ResumeAfter{"step", 1}), InputError);
    CHECK_THROWS_AS(CsvLog(comm, folder / "absent/h.csv", {"step"}).begin(), MachineError);
    comm.barrier();
    CsvLog anew(comm, path, {"step"});
    anew.begin();
    CHECK(content_of(path) == "step\n");
    CsvLog first(comm, folder / "new.csv", {"step"}, ResumeAfter{"step", 1});
    first.begin();
    CHECK(content_of(folder / "new.csv") == "step\n");
}

TEST_CASE("a resumed table is of the run whose row it is told, or refused and left as it was") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "h.csv";
    {
        CsvLog log(comm, path, {"step", "x"});
        log.begin();
        for (const double step : {1, 2, 3}) log.row(std::vector<double>{step, step / 7});
        if (comm.is_root()) CHECK(log.last_row() == "3,0.42857142857142855");
    }
    const std::string before = content_of(path);
    comm.barrier();
    CHECK_THROWS_AS(CsvLog(comm, path, {"step", "x"}, ResumeAfter{"step", 2, "2,0.3"}), InputError);
    CHECK(content_of(path) == before);
    comm.barrier();
    CHECK_THROWS_AS(CsvLog(comm, path, {"step", "x"}, ResumeAfter{"step", 2, "3,0.42857142857142855"}), InputError);
    {
        CsvLog log(comm, path, {"step", "x"}, ResumeAfter{"step", 2, "1,0.14285714285714285"});
        if (comm.is_root()) CHECK(log.last_row() == "2,0.2857142857142857");
    }
    comm.barrier();
    CsvLog gone(comm, folder / "gone.csv", {"step", "x"}, ResumeAfter{"step", 2, "1,0.14285714285714285"});
    gone.begin();
    CHECK(content_of(folder / "gone.csv") == "step,x\n");
}

TEST_CASE("a damaged row from before the checkpoint is named, and the table left as it was") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "h.csv";
    for (const std::string& damaged :
         {std::string("rubbish"), std::string("1\0.1", 4), std::string("1,0.1\x01"), std::string("1")}) {
        const std::string text = "step,x\n0,0\n" + damaged + "\n2,0.2\n3,0.3\n";
        if (comm.is_root()) set_content(path, text);
        comm.barrier();
        CHECK_THROWS_WITH_AS(
            CsvLog(comm, path, {"step", "x"}, ResumeAfter{"step", 2}),
            ("cannot continue " + path + " (line 3 is damaged). Mend or remove the line, or another --output?").c_str(),
            InputError);
        CHECK(content_of(path) == text);
        comm.barrier();
    }
}

TEST_CASE("a directory that is not there is not taken for a full disk") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    CHECK_THROWS_WITH_AS(CsvLog(comm, folder / "gone/h.csv", {"step"}).begin(),
                         ("cannot open " + folder / "gone/h.csv.partial" +
                          " (No such file or directory). Is the directory gone, or on a disk that not all hosts share?")
                             .c_str(),
                         MachineError);
}
