import pytest

from aicon_torch.extras import import_extra


def test_a_module_that_is_there_is_imported() -> None:
    assert import_extra("json.decoder", "robots").JSONDecoder


def test_a_module_that_is_missing_is_named_with_the_command_that_brings_it() -> None:
    message = r"no_such_module is missing; it comes with: pip install 'aicon-torch\[robots\]'"
    with pytest.raises(ModuleNotFoundError, match=message) as raised:
        import_extra("no_such_module.part", "robots")
    assert raised.value.name == "no_such_module"
