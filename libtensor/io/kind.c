/* SPDX-License-Identifier: Apache-2.0 */
/* First bytes of files that people have, and what each is called. */
#include "libtensor/io/kind.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static const struct { const char *name, *hint; } kinds[LT_KINDS] = {
    [LT_KIND_UNKNOWN] = { "unknown", NULL },
    [LT_KIND_EMPTY] = { "an empty file", "did its download fail?" },
    [LT_KIND_LFS] = { "a git-lfs pointer in the place of a file", "\"git lfs pull\" fetches it" },
    [LT_KIND_HTML] = { "an HTML page in the place of a file", "download it again, or with a browser" },
    [LT_KIND_ZIP] = { "a zip archive", "unpack it first" },
    [LT_KIND_GZIP] = { "a gzip file", "unpack it first: gzip -d" },
    [LT_KIND_XZ] = { "an xz file", "unpack it first: xz -d" },
    [LT_KIND_BZIP2] = { "a bzip2 file", "unpack it first: bzip2 -d" },
    [LT_KIND_ZSTD] = { "a zstd file", "unpack it first: zstd -d" },
    [LT_KIND_7Z] = { "a 7z archive", "unpack it first" },
    [LT_KIND_RAR] = { "a rar archive", "unpack it first" },
    [LT_KIND_TAR] = { "a tar archive", "unpack it first" },
    [LT_KIND_PICKLE] = { "a pickle of Python", NULL },
    [LT_KIND_TORCH_ZIP] = { "a checkpoint of PyTorch", NULL },
    [LT_KIND_TORCH_STREAM] = { "a checkpoint of PyTorch", NULL },
    [LT_KIND_SAFETENSORS] = { "a safetensors file", NULL },
    [LT_KIND_NPY] = { "a .npy array", NULL },
    [LT_KIND_NPZ] = { "an .npz archive", NULL },
    [LT_KIND_HDF5] = { "an HDF5 file", "save what is in it with numpy.savez" },
    [LT_KIND_MATLAB] = { "a MATLAB file", "save what is in it with numpy.savez" },
    [LT_KIND_PNG] = { "a PNG image", NULL },
    [LT_KIND_JPEG] = { "a JPEG image", NULL },
    [LT_KIND_HEIC] = { "a HEIC image", "set the camera to Most Compatible, or convert it to JPEG" },
    [LT_KIND_AVIF] = { "an AVIF image", "convert it to PNG or JPEG" },
    [LT_KIND_WEBP] = { "a WebP image", NULL },
    [LT_KIND_TIFF] = { "a TIFF image", NULL },
    [LT_KIND_GIF] = { "a GIF image", "convert it to PNG" },
    [LT_KIND_BMP] = { "a BMP image", NULL },
    [LT_KIND_MP4] = { "a film (MP4 or QuickTime)", NULL },
    [LT_KIND_MATROSKA] = { "a film (Matroska or WebM)", NULL },
    [LT_KIND_AVI] = { "a film (AVI)", NULL },
    [LT_KIND_PLY] = { "a PLY file", NULL },
    [LT_KIND_GLB] = { "a binary glTF file", NULL },
    [LT_KIND_PDF] = { "a PDF document", NULL },
    [LT_KIND_JSON] = { "a JSON file", NULL },
};

/* Bytes that stand at a place, for kinds that need no more */
static const struct { lt_kind kind; size_t at, n; const char *bytes; } marks[] = {
    { LT_KIND_LFS, 0, 35, "version https://git-lfs.github.com/" },
    { LT_KIND_ZIP, 0, 4, "PK\3\4" }, { LT_KIND_ZIP, 0, 4, "PK\5\6" },
    { LT_KIND_GZIP, 0, 3, "\x1f\x8b\x08" },
    { LT_KIND_XZ, 0, 6, "\xfd" "7zXZ\0" },
    { LT_KIND_BZIP2, 0, 3, "BZh" },
    { LT_KIND_ZSTD, 0, 4, "\x28\xb5\x2f\xfd" },
    { LT_KIND_7Z, 0, 6, "7z\xbc\xaf\x27\x1c" },
    { LT_KIND_RAR, 0, 6, "Rar!\x1a\x07" },
    { LT_KIND_TAR, 257, 5, "ustar" },
    { LT_KIND_NPY, 0, 6, "\x93NUMPY" },
    { LT_KIND_HDF5, 0, 8, "\x89HDF\r\n\x1a\n" },
    { LT_KIND_MATLAB, 0, 10, "MATLAB 5.0" },
    { LT_KIND_PNG, 0, 8, "\x89PNG\r\n\x1a\n" },
    { LT_KIND_JPEG, 0, 3, "\xff\xd8\xff" },
    { LT_KIND_WEBP, 8, 4, "WEBP" },
    { LT_KIND_TIFF, 0, 4, "II*\0" }, { LT_KIND_TIFF, 0, 4, "MM\0*" },
    { LT_KIND_GIF, 0, 4, "GIF8" },
    { LT_KIND_MATROSKA, 0, 4, "\x1a\x45\xdf\xa3" },
    { LT_KIND_AVI, 8, 4, "AVI " },
    { LT_KIND_PLY, 0, 4, "ply\n" }, { LT_KIND_PLY, 0, 5, "ply\r\n" },
    { LT_KIND_GLB, 0, 4, "glTF" },
    { LT_KIND_PDF, 0, 5, "%PDF-" },
};

/* The brands of ISO's base media format: stills of phones have their own, all others are films. */
static lt_kind media_kind(const uint8_t *bytes, size_t n)
{
    static const char *const heic[] = { "heic", "heix", "hevc", "hevx", "heim", "heis", "mif1", "msf1" };
    static const char *const film[] = { "moov", "mdat", "wide", "free", "skip" };       /* QuickTime before brands */

    if (n < 12)
        return LT_KIND_UNKNOWN;
    for (size_t i = 0; i < LT_COUNT(film); i++)
        if (memcmp(bytes + 4, film[i], 4) == 0)
            return LT_KIND_MP4;
    if (memcmp(bytes + 4, "ftyp", 4) != 0)
        return LT_KIND_UNKNOWN;
    for (size_t i = 0; i < LT_COUNT(heic); i++)
        if (memcmp(bytes + 8, heic[i], 4) == 0)
            return LT_KIND_HEIC;
    return memcmp(bytes + 8, "avif", 4) == 0 || memcmp(bytes + 8, "avis", 4) == 0 ? LT_KIND_AVIF : LT_KIND_MP4;
}

/* The header's length in 8 bytes, then the header, which is an object of JSON */
static bool is_safetensors(const uint8_t *bytes, size_t n)
{
    return n >= 10 && bytes[5] == 0 && bytes[6] == 0 && bytes[7] == 0 && bytes[8] == '{' &&
           (bytes[9] == '"' || bytes[9] == '}' || bytes[9] == ' ' || bytes[9] == '\n');
}

/* What an archive begins with tells whose it is: PyTorch's with NAME/data.pkl, NumPy's with NAME.npy. */
static lt_kind zip_kind(const uint8_t *bytes, size_t n)
{
    static const char torch[] = "/data.pkl", npz[] = ".npy";
    const size_t length = n >= 30 ? bytes[26] | (size_t)bytes[27] << 8 : 0;
    const uint8_t *end = bytes + 30 + length;

    if (length == 0 || length > n - 30)
        return LT_KIND_ZIP;
    if (length >= sizeof(torch) - 1 && memcmp(end - (sizeof(torch) - 1), torch, sizeof(torch) - 1) == 0)
        return LT_KIND_TORCH_ZIP;
    return length >= sizeof(npz) - 1 && memcmp(end - (sizeof(npz) - 1), npz, sizeof(npz) - 1) == 0 ? LT_KIND_NPZ
                                                                                                    : LT_KIND_ZIP;
}

/* A stream of PyTorch's begins with a pickled number: LONG1 of 10 bytes behind the protocol. */
static bool is_torch_stream(const uint8_t *bytes, size_t n)
{
    static const uint8_t number[] = "\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19.";

    return n >= 15 && bytes[0] == 0x80 && memcmp(bytes + 2, number, 13) == 0;
}

static bool is_pickle(const uint8_t *bytes, size_t n)
{
    return n >= 2 && bytes[0] == 0x80 && bytes[1] >= 2 && bytes[1] <= 5;
}

/* The size behind the letters, low byte first, is not below that of its own headers. */
static bool is_bmp(const uint8_t *bytes, size_t n)
{
    return n >= 26 && bytes[0] == 'B' && bytes[1] == 'M' && bytes[6] == 0 && bytes[7] == 0 && bytes[8] == 0 &&
           bytes[9] == 0;
}

static lt_kind text_kind(const uint8_t *bytes, size_t n)
{
    static const char *const pages[] = { "<!doctype html", "<html" };
    size_t blank = 0;

    while (blank < n && memchr(" \t\r\n", bytes[blank], 4))
        blank++;
    for (size_t i = 0; i < LT_COUNT(pages); i++)
        if (n - blank >= strlen(pages[i]) && strncasecmp((const char *)bytes + blank, pages[i], strlen(pages[i])) == 0)
            return LT_KIND_HTML;
    return n - blank >= 2 && (bytes[blank] == '{' || bytes[blank] == '[') ? LT_KIND_JSON : LT_KIND_UNKNOWN;
}

lt_kind lt_kind_of(const uint8_t *bytes, size_t n)
{
    lt_kind kind;

    if (n == 0)
        return LT_KIND_EMPTY;
    for (size_t i = 0; i < LT_COUNT(marks); i++)
        if (n >= marks[i].at + marks[i].n && memcmp(bytes + marks[i].at, marks[i].bytes, marks[i].n) == 0)
            return marks[i].kind == LT_KIND_ZIP ? zip_kind(bytes, n) : marks[i].kind;
    kind = media_kind(bytes, n);
    if (kind)
        return kind;
    if (is_safetensors(bytes, n))
        return LT_KIND_SAFETENSORS;
    if (is_torch_stream(bytes, n))
        return LT_KIND_TORCH_STREAM;
    if (is_pickle(bytes, n))
        return LT_KIND_PICKLE;
    return is_bmp(bytes, n) ? LT_KIND_BMP : text_kind(bytes, n);
}

const char *lt_kind_name(lt_kind kind)
{
    return kinds[kind].name;
}

const char *lt_kind_hint(lt_kind kind)
{
    return kinds[kind].hint;
}

lt_kind lt_kind_of_file(const char *path)
{
    struct stat info;
    uint8_t bytes[512];
    FILE *f = stat(path, &info) == 0 && S_ISREG(info.st_mode) ? fopen(path, "rb") : NULL;
    size_t n;
    bool read;

    if (!f)
        return LT_KIND_UNKNOWN;
    n = fread(bytes, 1, sizeof(bytes), f);
    read = !ferror(f);
    fclose(f);
    return read ? lt_kind_of(bytes, n) : LT_KIND_UNKNOWN;
}

lt_status lt_refuse_kind(const char *name, lt_kind kind, const char *want)
{
    const char *hint = lt_kind_hint(kind);

    if (!kind)
        return lt_error(LT_EFORMAT, "%s: not %s", name, want);
    return lt_error(LT_EFORMAT, "%s: %s, want %s%s%s", name, lt_kind_name(kind), want, hint ? "; " : "",
                    hint ? hint : "");
}

lt_status lt_refuse(const char *name, const uint8_t *bytes, size_t n, const char *want)
{
    return lt_refuse_kind(name, lt_kind_of(bytes, n), want);
}

lt_status lt_refuse_cut(const char *name, lt_kind kind, const char *fmt, ...)
{
    char reason[256];
    va_list args;

    va_start(args, fmt);
    vsnprintf(reason, sizeof(reason), fmt, args);
    va_end(args);
    return lt_error(LT_EFORMAT, "%s: %s that is cut short: %s; copy or download it again", name, lt_kind_name(kind),
                    reason);
}

lt_status lt_refuse_other(const char *name, const uint8_t *bytes, size_t n, lt_kind own, const char *want)
{
    const lt_kind kind = lt_kind_of(bytes, n);

    return kind && kind != LT_KIND_EMPTY && kind != own ? lt_refuse(name, bytes, n, want) : LT_OK;
}

bool lt_kind_is_zip(lt_kind kind)
{
    return kind == LT_KIND_ZIP || kind == LT_KIND_NPZ || kind == LT_KIND_TORCH_ZIP;
}
