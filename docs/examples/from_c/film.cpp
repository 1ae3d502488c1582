// film RUN WIDTH HEIGHT: the tips of an index finger and a thumb through a film, smoothed. Frames come as raw pixels:
// ffmpeg -i film.mp4 -f rawvideo -pix_fmt rgb24 - | film RUN 640 480
#include <palmar.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

int main(int argc, char **argv)
{
    palmar *opened = nullptr;
    if (argc != 4 || palmar_open(argv[1], nullptr, &opened) || palmar_film(opened, 30))
        return std::fprintf(stderr, "film RUN WIDTH HEIGHT: %s\n", palmar_last_error()), 1;
    std::unique_ptr<palmar, decltype(&palmar_close)> p(opened, palmar_close);

    palmar_image image{};
    image.width = std::atoi(argv[2]);
    image.height = std::atoi(argv[3]);
    std::vector<uint8_t> rgb(3 * size_t(image.width) * size_t(image.height));
    image.rgb = rgb.data();
    palmar_query where{};
    palmar_hand hand;
    while (std::fread(rgb.data(), 1, rgb.size(), stdin) == rgb.size() && !rgb.empty()) {
        if (palmar_estimate(p.get(), &image, 1, &where, &hand))
            return std::fprintf(stderr, "%s\n", palmar_last_error()), 1;
        const float *a = hand.joints[4], *b = hand.joints[8];
        const double apart = std::hypot(a[0] - b[0], std::hypot(a[1] - b[1], a[2] - b[2]));
        std::printf("pinch %.4f m%s\n", apart, hand.trusted ? "" : ", doubtful");
    }
}
