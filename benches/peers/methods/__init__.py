"""Ways to fill the space between sections. Each takes sections and gives a mesh."""

from importlib import import_module

from program import knows_method

OURS = ("variational", "mvc", "skeleton")
#: A module and a function in it, loaded when wanted: ITK takes seconds.
PEERS = {
    "slices-linear": ("slicewise", "linear"),
    "slices-cubic": ("slicewise", "cubic"),
    "itk": ("itk", "reconstruct"),
    "rbf": ("rbf", "reconstruct"),
}


def available(names):
    """Those of the names that can be run, in their order; the others and why."""
    unknown = [name for name in names if name not in OURS and name not in PEERS]
    missing = [name for name in names if name in OURS and not knows_method(name)]
    why = {name: "there is no such method" for name in unknown}
    why |= {name: "the program does not know this method" for name in missing}
    return [name for name in names if name not in why], why


def method(name):
    """A function of a file of sections, the sections in it, and the resolution."""
    if name in OURS:
        ours = import_module("methods.ours")
        return lambda file, sections, resolution: ours.reconstruct(name, file, resolution)
    module, function = PEERS[name]
    peer = getattr(import_module(f"methods.{module}"), function)
    return lambda file, sections, resolution: peer(sections, resolution)
