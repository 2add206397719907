"""Those who may not look, and those who may with a certificate or a login."""

import http.client
import json
import re
import ssl

from browser import PATIENCE, Browser
from farm import Farm, check

SENT = """fetch('api/{}', {{method: '{}', headers: {{'Content-Type': 'application/json', 'X-Tessera': '1'}},
  body: {}}}).then((r) => r.status)"""


async def strangers(farm, browser):
    """Pages of other sites read nothing and change nothing; nothing can be uploaded."""
    job = farm.submit("scenes/first-light/scene.textproto", "--spp", "4096")
    await browser.open("data:text/html,<title>stranger</title>")
    tried = (
        "Promise.allSettled([fetch('{0}api/me'), fetch('{0}api/job?id={1}'),"
        " fetch('{0}api/cancel', {{method: 'POST', mode: 'no-cors', body: '{{\"id\":\"{1}\"}}'}})]).then((all) =>"
        " all.filter((one) => one.status === 'fulfilled' && one.value.type !== 'opaque').length)"
    )
    check(await browser.evaluate(tried.format(farm.page(), job)) == 0, "a page of another site could read")
    await browser.open(farm.page())
    await browser.until(f"jobs.has({job!r})")
    state = await browser.evaluate(f"jobs.get({job!r}).state")
    check(state != "CANCELLED", "a page of another site cancelled a job")
    for action in ("submit", "upload", "delete", "expel"):
        check(await browser.evaluate(SENT.format(action, "POST", "'{}'")) == 404, action)
    check(await browser.evaluate(SENT.format("job", "PUT", "'{}'")) == 405, "PUT")
    check(await browser.evaluate(SENT.format("cancel", "POST", "'x'.repeat(5000)")) == 413, "a long request")
    farm.tessera("cancel", job)


def https(farm, path, host="farm.example", session="", body=None, certificate=None, newest=ssl.TLSVersion.TLSv1_3):
    """Status and headers of an answer over TLS, whose certificate must be the farm's."""
    context = ssl.create_default_context(cafile=farm.certificates / "server" / "ca.pem")
    context.check_hostname = False  # of 127.0.0.1, which is in it, too
    context.maximum_version = newest
    if certificate:
        context.load_cert_chain(certificate / "certificate.pem", certificate / "key.pem")
    connection = http.client.HTTPSConnection("127.0.0.1", int(farm.web), context=context, timeout=PATIENCE)
    headers = {"Host": f"{host}:{farm.web}", "Cookie": session}
    if body is not None:
        headers.update({"Content-Type": "application/json", "X-Tessera": "1"})
    connection.request("GET" if body is None else "POST", path, body=body, headers=headers)
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer.status, dict(answer.getheaders())


async def certificates(programs, screenshots):
    """With --tls the page is encrypted, and answers those with a certificate or a login alone."""
    farm = Farm(programs, tls=True)
    try:
        ada, worker = farm.certificates / "client-ada", farm.certificates / "worker"
        check(https(farm, "/")[0] == 200, "the page by a name in the certificate")
        check(https(farm, "/", host="evil.example")[0] == 403, "the page by another name")
        check(https(farm, "/api/me")[0] == 401, "somebody unknown")
        check(https(farm, "/api/me", certificate=ada)[0] == 200, "a client's certificate")
        check(https(farm, "/api/me", certificate=worker)[0] == 403, "a worker's certificate")
        try:
            https(farm, "/", newest=ssl.TLSVersion.TLSv1_2)
            check(False, "TLS 1.2 was spoken")
        except (ssl.SSLError, OSError):
            pass
        address = farm.tessera("token", "--web", "--tls", ada)
        check(re.fullmatch(rf"https://127.0.0.1:{farm.web}/#login=[0-9a-f]+", address), address)
        token = json.dumps({"token": address.split("=")[1]})
        status, headers = https(farm, "/api/login", body=token)
        check(status == 200 and "HttpOnly" in headers["Set-Cookie"], "the login")
        check(https(farm, "/api/login", body=token)[0] == 403, "a token that was used")
        session = headers["Set-Cookie"].split(";")[0]
        check(https(farm, "/api/me", session=session)[0] == 200, "a session")
        if screenshots:
            async with Browser() as browser:
                await browser.open(farm.page())
                await browser.until("!document.getElementById('page-login').hidden")
                await browser.screenshot(screenshots / "web-login.png")
    finally:
        farm.end()
