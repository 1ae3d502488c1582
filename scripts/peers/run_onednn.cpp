/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measure one dense layer in oneDNN, called directly in its own blocked layouts; for scripts/bench-peers.
 *
 *     run_onednn conv2d BATCH C O K STRIDE GROUPS HW RUNS SECONDS
 *     run_onednn linear ROWS C O RUNS SECONDS
 *
 * The fastest of oneDNN's algorithms counts. The weights are as cold as palmar bench --layer has them: copies
 * that make 100 MB, at most 1024 and at least 8, one after another. Prints one line of JSON.
 */
#include <dnnl.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <sys/resource.h>
#include <unordered_map>
#include <vector>

using namespace dnnl;
using tag = memory::format_tag;

static engine cpu(engine::kind::cpu, 0);
static stream queue(cpu);

/* A primitive, what it reads and writes, and its copies of the weights. */
struct layer {
    std::string how;
    primitive run;
    memory src, bias, dst;
    std::vector<memory> weights;
};

struct timing {
    double median, least;
    size_t runs;
};

static memory filled(const memory::desc &d, float value)
{
    memory m(d, cpu);

    std::fill_n(static_cast<float *>(m.get_data_handle()), d.get_size() / sizeof(float), value);
    return m;
}

template <class desc> static layer make(const std::string &how, const desc &pd)
{
    const size_t bytes = pd.weights_desc().get_size();
    const size_t copies = std::clamp<size_t>((100000000 + bytes - 1) / bytes, 8, 1024);
    layer l { how, primitive(pd), filled(pd.src_desc(), 0.5f), filled(pd.bias_desc(), 0.1f),
              filled(pd.dst_desc(), 0), {} };

    for (size_t i = 0; i < copies; i++)
        l.weights.push_back(filled(pd.weights_desc(), 0.01f));
    return l;
}

static memory::desc any(const memory::dims &d)
{
    return memory::desc(d, memory::data_type::f32, tag::any);
}

static std::vector<layer> convolutions(char **a)
{
    const int64_t n = atoi(a[0]), c = atoi(a[1]), o = atoi(a[2]), k = atoi(a[3]), s = atoi(a[4]), g = atoi(a[5]);
    const int64_t hw = atoi(a[6]), pad = (k - 1) / 2, out = (hw + 2 * pad - k) / s + 1;
    const memory::dims weights = g > 1 ? memory::dims { g, o / g, c / g, k, k } : memory::dims { o, c, k, k };
    const std::pair<const char *, algorithm> algorithms[] = {
        { "direct", algorithm::convolution_direct }, { "Winograd", algorithm::convolution_winograd },
    };
    std::vector<layer> list;

    for (const auto &alg : algorithms)
        try {
            const convolution_forward::desc d(prop_kind::forward_inference, alg.second, any({ n, c, hw, hw }),
                                              any(weights), any({ o }), any({ n, o, out, out }), { s, s },
                                              { pad, pad }, { pad, pad });

            list.push_back(make(alg.first, convolution_forward::primitive_desc(d, cpu)));
        } catch (const dnnl::error &) {                 /* an algorithm that does not do this shape */
        }
    return list;
}

static std::vector<layer> linears(char **a)
{
    const int64_t rows = atoi(a[0]), c = atoi(a[1]), o = atoi(a[2]);
    const inner_product_forward::desc d(prop_kind::forward_inference, any({ rows, c }), any({ o, c }), any({ o }),
                                        any({ rows, o }));

    return { make("inner product", inner_product_forward::primitive_desc(d, cpu)) };
}

static double now_ms()
{
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

static void once(const layer &l)
{
    for (const memory &w : l.weights)
        l.run.execute(queue, { { DNNL_ARG_SRC, l.src }, { DNNL_ARG_WEIGHTS, w }, { DNNL_ARG_BIAS, l.bias },
                               { DNNL_ARG_DST, l.dst } });
    queue.wait();
}

static timing measure(const layer &l, size_t runs, double seconds)
{
    std::vector<double> ms;

    for (size_t i = 0; i < std::min<size_t>(3, runs); i++)
        once(l);
    for (const double start = now_ms(); ms.empty() || (ms.size() < runs && now_ms() - start < 1e3 * seconds);) {
        const double t = now_ms();

        once(l);
        ms.push_back((now_ms() - t) / double(l.weights.size()));
    }
    std::sort(ms.begin(), ms.end());
    return { (ms[(ms.size() - 1) / 2] + ms[ms.size() / 2]) / 2, ms[0], ms.size() };
}

int main(int argc, char **argv)
{
    const bool conv = argc == 11 && strcmp(argv[1], "conv2d") == 0;
    const bool linear = argc == 7 && strcmp(argv[1], "linear") == 0;
    timing best { 1e300, 0, 0 };
    std::string how;
    rusage usage;

    if (!conv && !linear) {
        fprintf(stderr, "usage: run_onednn conv2d|linear SIZES RUNS SECONDS\n");
        return 2;
    }
    for (const layer &l : conv ? convolutions(argv + 2) : linears(argv + 2)) {
        const timing t = measure(l, size_t(atoi(argv[argc - 2])), atof(argv[argc - 1]));

        if (t.median < best.median) {
            best = t;
            how = l.how;
        }
    }
    getrusage(RUSAGE_SELF, &usage);
    printf("{\"median_ms\": %.6g, \"min_ms\": %.6g, \"runs\": %zu, \"peak_rss_mb\": %.1f, \"how\": \"%s\", "
           "\"version\": \"%d.%d.%d\"}\n", best.median, best.least, best.runs, double(usage.ru_maxrss) / 1024,
           how.c_str(), DNNL_VERSION_MAJOR, DNNL_VERSION_MINOR, DNNL_VERSION_PATCH);
    return best.runs ? 0 : 1;
}
