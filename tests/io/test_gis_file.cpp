#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/data/error.hpp"
#include "io/netcdf_size.hpp"
#include "io/terrain_model.hpp"

using namespace moraine;

namespace {

/// Gone with the test case.
class TestFolder {
  public:
    TestFolder()
        : path_(std::filesystem::temp_directory_path() /
                ("moraine-gis-" + std::to_string(getpid()) + "-" + std::to_string(++made))) {
        std::filesystem::create_directories(path_);
    }
    ~TestFolder() { std::filesystem::remove_all(path_); }
    TestFolder(const TestFolder&) = delete;
    TestFolder& operator=(const TestFolder&) = delete;
    std::string with(const std::string& name, const std::string& bytes) const {
        std::ofstream(path_ / name, std::ios::binary) << bytes;
        return (path_ / name).string();
    }
    std::string path(const std::string& name) const { return (path_ / name).string(); }
    std::size_t files() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
    }

  private:
    static inline int made = 0;
    std::filesystem::path path_;
};

struct Plane : MapImage {
    std::vector<float> values;  ///< rows from north to south
};

std::string bytes_of(Plane image) {
    image.row = [&](std::int64_t j, float* to) {
        std::copy_n(image.values.begin() + j * image.size[0], image.size[0], to);
    };
    return geotiff_bytes(image);
}

/// 40 x 30 heights 100 + x + 2 y of cells of 2 m from (500000, 5300000) on; one of them not known.
Plane plane(const std::string& crs) {
    Plane image{{{40, 30}, {500000, 5300000}, 2, crs, "height", "m", -9999, {}}, {}};
    for (int j = 29; j >= 0; --j)
        for (int i = 0; i < 40; ++i) image.values.push_back(float(100 + (2 * i + 1) + 2 * (2 * j + 1)));
    image.values[0] = -9999;  // north-western corner
    return image;
}

/// A raster of 4 x 3 zeros, described in words.
std::string virtual_raster(const std::string& transform, const std::string& type, const std::string& more,
                           int bands = 1) {
    std::string text =
        "<VRTDataset rasterXSize=\"40\" rasterYSize=\"30\"><GeoTransform>" + transform + "</GeoTransform>";
    for (int b = 1; b <= bands; ++b)
        text +=
            "<VRTRasterBand dataType=\"" + type + "\" band=\"" + std::to_string(b) + "\">" + more + "</VRTRasterBand>";
    return text + "</VRTDataset>";
}

const std::string upright = "500000, 2, 0, 5300060, 0, -2";
constexpr PlanPoint low{500010, 5300010}, high{500050, 5300040};

std::string said_of_model(const std::string& path) {
    std::vector<std::string> notices;
    try {
        read_model(path, low, high, notices);
    } catch (const InputError& e) {
        return e.what();
    }
    return notices.empty() ? "" : notices[0];
}

std::string said_of_areas(const std::string& path, const std::string& crs) {
    std::vector<std::string> notices;
    try {
        read_areas(path, "release.area", crs, notices);
    } catch (const InputError& e) {
        return e.what();
    }
    return notices.empty() ? "" : notices[0];
}

bool has(const std::string& text, const std::string& part) {
    CAPTURE(text);
    CHECK(text.find(part) != std::string::npos);
    return text.find(part) != std::string::npos;
}

std::string polygon(const std::string& ring, const std::string& properties = "{}") {
    return R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":)" + properties +
           R"(,"geometry":{"type":"Polygon","coordinates":)" + ring + "}}]}";
}

const std::string zone = "EPSG:25832";

}  // namespace

TEST_CASE("a GeoTIFF is the grid that it was, with its system and what is not known") {
    const TestFolder folder;
    const std::string path = folder.with("g.tif", bytes_of(plane(zone)));
    std::vector<std::string> notices;
    const Ground g = read_model(path, low, high, notices);
    CHECK(notices.empty());
    CHECK(folder.files() == 1);
    CHECK(g.spacing == 2);
    CHECK(g.first == std::array<double, 2>{500003, 5300003});
    CHECK(g.count == std::array<std::int64_t, 2>{28, 23});
    CHECK(g.height[0] == 100 + 3 + 2 * 3);
    CHECK(g.height.back() == 100 + 57 + 2 * 47);
    CHECK(g.crs.find("25832") != std::string::npos);
    const Ground all = read_gis_raster(
        path, {},
        [](const Ground& shape) {
            return NodeWindow{{0, 0}, shape.count};
        },
        notices);
    CHECK(std::isnan(all.height[29 * 40]));
    CHECK(all.height[29 * 40 + 1] == 100 + 3 + 2 * 59);
}

TEST_CASE("a model that is not in metres, turned or of several bands is refused with what it is") {
    const TestFolder folder;
    CHECK(has(said_of_model(folder.with("g.tif", bytes_of(plane("EPSG:4326")))), "is in degrees (WGS 84 (EPSG:4326))"));
    CHECK(has(said_of_model(folder.with("g.tif", bytes_of(plane("EPSG:2263")))), "is in US survey foot"));
    const auto vrt = [&](const std::string& text) { return said_of_model(folder.with("g.vrt", text)); };
    CHECK(vrt(virtual_raster(upright, "Float32", "")).empty());
    CHECK(has(vrt(virtual_raster("500000, 2, 0.1, 5300060, 0, -2", "Float32", "")), "cells must be squares"));
    CHECK(has(vrt(virtual_raster("500000, 2, 0, 5300090, 0, -3", "Float32", "")), "cells of 2 x 3"));
    CHECK(has(vrt(virtual_raster(upright, "Byte", "", 3)), "the raster has 3 bands"));
    CHECK(has(vrt(virtual_raster(upright, "Float32", "<UnitType>ft</UnitType>")), "heights in \"ft\""));
    CHECK(has(vrt(virtual_raster(upright, "Int16", "")), "heights are whole numbers (Int16)"));
    CHECK(
        has(vrt(virtual_raster(upright, "Float32", "<NoDataValue>0</NoDataValue>")), "no height at (500011, 5300011)"));
    CHECK(has(said_of_model(folder.with("g.tif", "II*")), "the terrain model cannot be read"));
    CHECK(has(said_of_model("/nowhere/g.tif"), "no such file"));
    CHECK(has(said_of_model("/tmp"), "not a regular file"));
    Plane image = plane(zone);
    image.values[20 * 40 + 10] = INFINITY;
    CHECK(has(said_of_model(folder.with("g.tif", bytes_of(image))), "the height at (500021, 5300019) is infinite"));
    image.corner[0] += 100;
    CHECK(has(said_of_model(folder.with("g.tif", bytes_of(image))), "the model reaches from 500100 to 500180"));
}

TEST_CASE("axes that count down or south, heights in feet and a far scale are refused, whatever system has them") {
    const TestFolder folder;
    const auto said = [&](const std::string& crs, std::array<double, 2> corner = {500000, 5300000}) {
        Plane image = plane(crs);
        image.corner = corner;
        std::vector<std::string> notices;
        try {
            read_model(folder.with("g.tif", bytes_of(image)), {corner[0] + 10, corner[1] + 10},
                       {corner[0] + 50, corner[1] + 40}, notices);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    CHECK(said("EPSG:25832").empty());
    CHECK(said("EPSG:32632+5773").empty());  // heights over EGM96
    CHECK(has(said("EPSG:32632+5715"), "its vertical axis points down"));
    CHECK(has(said("EPSG:32632+5831"), "its vertical axis points down"));
    CHECK(has(said("EPSG:32632+6360"), "heights in"));
    CHECK(has(said("EPSG:2053", {20000, 3000000}), "an axis points"));
    CHECK(has(said("EPSG:3857", {900000, 6000000}), "lengths are 1.47"));
    CHECK(has(said("EPSG:3395", {900000, 6000000}), "lengths are 1.4"));
    CHECK(said("EPSG:3031", {0, 1500000}).find("points") == std::string::npos);  // about the pole
    CHECK(said("EPSG:2056", {2600000, 1200000}).empty());
}

TEST_CASE("what a mask hides and what the format calls missing is not known") {
    const TestFolder folder;
    folder.with("g.tif", bytes_of(plane(zone)));
    const auto said = [&](const std::string& more) {
        return said_of_model(folder.with(
            "g.vrt",
            virtual_raster(upright, "Float32",
                           more +
                               "<SimpleSource><SourceFilename "
                               "relativeToVRT=\"1\">g.tif</SourceFilename><SourceBand>1</SourceBand></SimpleSource>")));
    };
    CHECK(said("").empty());
    CHECK(has(said("<UnitType>Feet</UnitType>"), "heights in"));
    CHECK(said("<UnitType>Meters</UnitType>").empty());
    CHECK(has(said("<Metadata><MDI key=\"positive\">down</MDI></Metadata>"), "count down"));
    CHECK(has(said("<Metadata><MDI key=\"missing_value\">163</MDI></Metadata>"), "no height at"));
}

TEST_CASE("a file opens nothing but itself and what lies in its folder") {
    const TestFolder folder, other;
    other.with("away.tif", bytes_of(plane(zone)));
    folder.with("g.tif", bytes_of(plane(zone)));
    const auto source = [&](const std::string& name, const std::string& more = "relativeToVRT=\"1\"") {
        return said_of_model(
            folder.with("x.tif", virtual_raster(upright, "Float32",
                                                "<SimpleSource><SourceFilename " + more + ">" + name +
                                                    "</SourceFilename><SourceBand>1</SourceBand></SimpleSource>")));
    };
    CHECK(source("g.tif").empty());
    for (const std::string& name :
         {std::string("/vsicurl/http://127.0.0.1:9/x.tif"), std::string("http://127.0.0.1:9/x.tif"),
          std::string("NETCDF:g.nc:z"), std::string("&#47;vsicurl/x"), std::string("<![CDATA[g.tif]]>")})
        CHECK(has(source(name), "a virtual raster that is not read here"));
    CHECK(has(source(other.path("away.tif"), ""), "lies outside of its folder"));
    CHECK(has(source("../" + std::filesystem::path(other.path("")).parent_path().filename().string() + "/away.tif"),
              "lies outside of its folder"));
    CHECK(has(source("none.tif"), "is not there"));
    CHECK(has(said_of_model(folder.with("x.tif", "<VRTDataset subClass=\"VRTWarpedDataset\"></VRTDataset>")),
              "subclass"));
    CHECK(has(said_of_model(folder.with(
                  "x.tif",
                  "<GDAL_WMS><Service name=\"TMS\"><ServerUrl>http://127.0.0.1:9/</ServerUrl></Service></GDAL_WMS>")),
              "cannot be read"));
    CHECK(has(
        said_of_areas(
            folder.with("a.gpkg",
                        "<OGRVRTDataSource><OGRVRTLayer "
                        "name=\"a\"><SrcDataSource>PG:host=127.0.0.1</SrcDataSource></OGRVRTLayer></OGRVRTDataSource>"),
            zone),
        "cannot be read"));
    std::string linked = polygon("[[[0,0],[1,0],[0,1],[0,0]]]");
    linked.insert(1, R"("crs":{"type":"link","properties":{"href":"http://127.0.0.1:9/x"}},)");
    CHECK(has(said_of_areas(folder.with("a.geojson", linked), zone), "its coordinate system is a link"));
    const std::size_t files = folder.files();
    const std::string gml = "<gml:FeatureCollection xmlns:gml=\"http://www.opengis.net/gml\"></gml:FeatureCollection>";
    CHECK(has(said_of_areas(folder.with("b.gml", gml), zone), "cannot be read"));
    CHECK(folder.files() == files + 1);  // and no b.gfs
    REQUIRE(::mkfifo(folder.path("g.tfw").c_str(), 0600) == 0);
    CHECK(has(said_of_model(folder.path("g.tif")), "g.tfw beside it is not a regular file"));
}

namespace {

std::string big_endian(std::initializer_list<std::uint32_t> list) {
    std::string bytes;
    for (const std::uint32_t number : list)
        for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift & 255);
    return bytes;
}

/// CDF-1 of one variable z of floats: 3 x 4, or 3 records of 4.
std::string classic_netcdf(bool records) {
    const std::string head = std::string("CDF\x01", 4) + big_endian({records ? 3u : 0u, 10, 2, 1}) +
                             std::string("y\0\0\0", 4) + big_endian({records ? 0u : 3u, 1}) +
                             std::string("x\0\0\0", 4) + big_endian({4, 0, 0, 11, 1, 1}) + std::string("z\0\0\0", 4) +
                             big_endian({2, 0, 1, 0, 0, 5, 16});
    return head + big_endian({static_cast<std::uint32_t>(head.size() + 4)}) + std::string(48, '\1');
}

}  // namespace

TEST_CASE("a netCDF file that is shorter than its header says is refused") {
    const TestFolder folder;
    for (bool records : {false, true}) {
        const std::string whole = classic_netcdf(records);
        check_netcdf_size(folder.with("whole.nc", whole));
        for (const std::size_t length : {whole.size() - 1, whole.size() - 48, whole.size() / 2, std::size_t(9)}) {
            CAPTURE(length);
            std::string said;
            try {
                check_netcdf_size(folder.with("cut.nc", whole.substr(0, length)));
            } catch (const InputError& e) {
                said = e.what();
            }
            CHECK(has(said, "cut short"));
        }
    }
    check_netcdf_size(folder.with("text.nc", "CDF is no magic"));
}

TEST_CASE("a model that would not fit into memory is refused before it is read, with its size") {
    const TestFolder folder;
    std::string text = virtual_raster("500000, 2, 0, 5300060, 0, -2", "Float32", "");
    text.replace(text.find("\"40\""), 4, "\"50000\"").replace(text.find("\"30\""), 4, "\"40000\"");
    std::vector<std::string> notices;
    std::string said;
    try {
        read_model(folder.with("g.vrt", text), {500010, 5220100}, {599990, 5300040}, notices);
    } catch (const InputError& e) {
        said = e.what();
    }
    CHECK(has(said, "2e+09 heights under the domain (48 GB on each rank; at most 2.7e+08 fit)"));
}

TEST_CASE("rows from south to north and scaled numbers are heights as any") {
    const TestFolder folder;
    Plane image = plane(zone);
    std::vector<std::string> notices;
    const std::string tif = folder.with("g.tif", bytes_of(image));
    const std::string source =
        "<Scale>2</Scale><Offset>1</Offset><SimpleSource><SourceFilename relativeToVRT=\"1\">g.tif</SourceFilename>"
        "<SourceBand>1</SourceBand></SimpleSource>";
    const Ground flipped = read_model(
        folder.with("g.vrt", virtual_raster("500000, 2, 0, 5300000, 0, 2", "Float32", source)), low, high, notices);
    CHECK(flipped.height[0] == 2 * (100 + 3 + 2 * 57) + 1);  // the row that was the northern one is the southern one
}

TEST_CASE("rasters of other values are of the part that they have, in the model's system") {
    const TestFolder folder;
    std::vector<std::string> notices;
    const std::string path = folder.with("g.tif", bytes_of(plane(zone)));
    const Ground model = read_model(path, low, high, notices);
    const RasterUse use{"raster of friction", "terrain.friction", "friction"};
    const auto said = [&](Plane image) {
        try {
            read_values(folder.with("v.tif", bytes_of(image)), use, model, low, high, notices);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    Plane part = plane(zone);
    part.corner = {500040, 5300020};
    const Ground values = read_values(folder.with("v.tif", bytes_of(part)), use, model, low, high, notices);
    CHECK(values.first == std::array<double, 2>{500041, 5300021});
    CHECK(values.count == std::array<std::int64_t, 2>{6, 11});
    CHECK(raster_value(values, 500042, 5300022) == doctest::Approx(100 + 2 + 2 * 2));
    CHECK(std::isnan(raster_value(values, 500039.9, 5300022)));
    part.crs = "EPSG:25833";
    CHECK(has(said(part), "another coordinate system than the model"));
    part.crs = "";
    CHECK(said(part).empty());
    part.crs = "EPSG:32632";  // the same zone by another datum, equal in place to PROJ
    CHECK(said(part).empty());
    part.corner[0] = 600000;
    CHECK(has(said(part), "reaches from 600000"));
}

TEST_CASE("polygons go to the model's system, with their attributes, and this is said") {
    const TestFolder folder;
    const std::string ring = "[[[9.0, 47.0], [9.001, 47.0], [9.001, 47.001], [9.0, 47.0]]]";
    const std::string path = folder.with("a.geojson", polygon(ring, R"({"thickness": 2.5, "name": "scar"})"));
    std::vector<std::string> notices;
    const auto areas = read_areas(path, "release.area", zone, notices);
    REQUIRE(areas.size() == 1);
    CHECK(areas[0].name == "scar");
    CHECK(areas[0].thickness == 2.5);
    REQUIRE(areas[0].points.size() == 3);
    CHECK(areas[0].points[0][0] == doctest::Approx(500000).epsilon(1e-9));  // the zone's central meridian
    CHECK(areas[0].points[0][1] == doctest::Approx(5205164).epsilon(1e-6));
    REQUIRE(notices.size() == 1);
    CHECK(has(notices[0], "reprojected from WGS 84 (EPSG:4326) to ETRS89 / UTM zone 32N (EPSG:25832)"));
    notices.clear();
    CHECK(read_areas(path, "release.area", "", notices)[0].points[0][0] == 9.0);
    CHECK(notices.empty());
    const std::string box =
        folder.with("o.gpkg", outline_bytes({{{{1, 2}, {5, 2}, {5, 6}}}, {{{8, 8}, {9, 8}, {9, 9}}}}, zone, 0.1, {}));
    const auto two = read_areas(box, "release.area", zone, notices);
    CHECK(notices.empty());
    REQUIRE(two.size() == 2);
    CHECK(two[1].points == std::vector<PlanPoint>{{8, 8}, {9, 8}, {9, 9}});
}

TEST_CASE("a file of areas that is none is refused with what it is") {
    const TestFolder folder;
    const auto said = [&](const std::string& text) { return said_of_areas(folder.with("a.geojson", text), zone); };
    CHECK(has(said(R"({"type":"Point","coordinates":[9,47]})"), "only polygons are read"));
    CHECK(has(
        said(polygon("[[[9,47],[9.1,47],[9.1,47.1],[9,47]],[[9.05,47.01],[9.06,47.01],[9.06,47.02],[9.05,47.01]]]")),
        "a polygon with a hole"));
    CHECK(has(said(polygon("[[[9,47],[9.1,47],[9.1,47.1],[9,47]]]", R"({"thickness": -1})")), "a thickness of -1 m"));
    CHECK(has(said(polygon("[[[500000,5200000],[500010,5200000],[500010,5200010],[500000,5200000]]]")),
              "cannot be reprojected"));
    CHECK(has(said(R"({"type":"FeatureCollection","features":[]})"), "no polygons were found"));
    CHECK(has(said("x"), "the file cannot be read"));
    CHECK(has(said_of_areas("/nowhere/a.gpkg", zone), "no such file"));
}

TEST_CASE("an ASCII grid has the system of the .prj beside it") {
    const TestFolder folder;
    const std::string asc = folder.with("g.asc", "ncols 3\n");
    CHECK(crs_beside(asc).empty());
    folder.with("g.prj",
                "PROJCS[\"x\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],"
                "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],"
                "PARAMETER[\"latitude_of_origin\",0],PARAMETER[\"central_meridian\",9],PARAMETER[\"scale_factor\","
                "0.9996],PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",0],UNIT[\"metre\",1]]");
    CHECK(has(crs_beside(asc), "Transverse"));
    folder.with("g.prj", "nothing");
    CHECK_THROWS_AS(crs_beside(asc), InputError);
}
